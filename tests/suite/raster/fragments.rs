//! Visible fragments by a closure: those of the visibility buffer, then the blended ones in front of them.
use texmap_math::glam::DMat4;
use texmap_raster::{BinnedDraws, DrawCall, NoAlphaTest, Pass, RasterError, triangles};

use crate::support::{Rng, fragments, jittered_grid, size};

#[test]
fn a_closure_sees_what_the_visibility_buffer_holds() {
    let mesh = jittered_grid(&mut Rng::new(7), 9).with_uv(|[x, y, _]| [x, y]);
    let draws = [
        mesh.draw(DMat4::IDENTITY),
        DrawCall {
            pass: Pass::Blended,
            ..mesh.draw(DMat4::from_translation([0.5, 0.0, 0.25].into()))
        },
        DrawCall {
            pass: Pass::Blended,
            ..mesh.draw(DMat4::from_translation([0.5, 0.0, -0.25].into()))
        },
    ];
    let prepared = BinnedDraws::new(size(150, 70), &draws).expect("valid draws");
    let mut want = Vec::new();
    fragments(&prepared, |triangle, x, y, f| {
        want.push((
            triangle,
            x,
            y,
            f.depth.to_bits(),
            f.values[1].to_bits(),
            f.ddx[0],
        ));
    });
    let (mut opaque, mut blended) = (Vec::new(), 0);
    prepared.for_each_fragment(&NoAlphaTest, |f| {
        assert_eq!((f.values.len(), f.ddx.len(), f.ddy.len()), (2, 2, 2));
        if f.draw == 0 {
            let [_, v] = f.values else { unreachable!() };
            opaque.push((
                f.triangle,
                f.x,
                f.y,
                f.depth.to_bits(),
                v.to_bits(),
                f.ddx[0],
            ));
        } else {
            assert_eq!(f.draw, 1, "the farther one is hidden");
            blended += 1;
        }
    });
    assert_eq!(opaque, want);
    // The grid fills the target; its copy begins at 37.5, the centre of a pixel, which the top-left rule gives to it.
    assert_eq!(opaque.len(), 150 * 70);
    assert_eq!(blended, 113 * 70);
}

#[test]
fn a_flat_list_is_a_list_of_triangles_or_refused() {
    let flat = [0, 1, 2, 2, 1, 3];
    assert_eq!(triangles(&flat), Ok(&[[0, 1, 2], [2, 1, 3]][..]));
    assert_eq!(triangles(&[]), Ok(&[][..]));
    assert_eq!(
        triangles(&flat[1..]),
        Err(RasterError::IndexCount { count: 5 })
    );
}
