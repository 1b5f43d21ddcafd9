//! Output arrays: values of the visible fragments from the attributes of their tile.

use texmap_raster::Fragment;

use super::rows::AovRows;
use crate::plan::{Plan, Surface};
use crate::{Aov, HOLE_BITS};
use texmap_shade::batch::{Batch, Facing};

/// Writes the values of a batch of `surface`.
pub(crate) fn write_batch(
    plan: &Plan<'_>,
    surface: &Surface<'_>,
    batch: &Batch<'_>,
    aovs: &mut [(Aov, AovRows<'_, '_>)],
) {
    let mut facing = Facing::new(surface.material.cull);
    let mut fragment = Fragment::default();
    for (place, at, bit) in batch.fragments() {
        let slot = batch.slot(at, bit);
        let (_, triangle) = batch.prepared.source(batch.blocks.ids[slot as usize]);
        fragment.depth = batch.depth(at, bit);
        fragment.inv_w = batch.values.inv_w[place];
        fragment.pixel = batch.sample(at, bit);
        fragment.front = facing.is_front(batch, slot);
        let columns = &batch.values.varyings[..surface.vertices.attribute_count];
        for (k, column) in columns.iter().enumerate() {
            fragment.values[k] = column.value[place];
            fragment.ddx[k] = column.ddx[place];
            fragment.ddy[k] = column.ddy[place];
        }
        let [x, y] = fragment.pixel;
        let (x, y) = ((x - batch.tile.x0) as usize, (y - batch.tile.y0) as usize);
        for (aov, rows) in &mut *aovs {
            match rows {
                AovRows::U32(rows) if *aov == Aov::Mesh => rows[y][x] = surface.number,
                AovRows::U32(rows) => rows[y][x] = surface.mesh.face(triangle),
                AovRows::F32(rows) => {
                    let channels = aov.channels();
                    let values = aov_values(*aov, plan, surface, &fragment, triangle);
                    rows[y][x * channels..][..channels].copy_from_slice(&values[..channels]);
                }
            }
        }
    }
}

/// Values of an f32 AOV, holes where the surface has none (or none that is finite).
fn aov_values(
    aov: Aov,
    plan: &Plan<'_>,
    surface: &Surface<'_>,
    fragment: &Fragment,
    triangle: u32,
) -> [f32; 3] {
    let hole = f32::from_bits(HOLE_BITS);
    let values = match aov {
        Aov::Depth => Some([fragment.depth, hole, hole]),
        Aov::InvW => Some([fragment.inv_w, hole, hole]),
        Aov::Uv => surface.uv.at(fragment).map(|(uv, _)| [uv[0], uv[1], hole]),
        Aov::Lod => surface
            .base_color
            .as_ref()
            .zip(surface.uv.at(fragment))
            .map(|(slot, (uv, d))| {
                let (_, d) = slot.place(uv, d);
                [slot.sampler.lod(&slot.texture, d), hole, hole]
            }),
        Aov::Normal => surface
            .normal
            .and_then(|first| unit(seen_normal(fragment, first))),
        Aov::Position => surface.position.map(|first| three(fragment, first)),
        Aov::Shadow(light) => surface.effects.as_ref().and_then(|effects| {
            let point = three(fragment, surface.position?);
            let plane = effects.plane(triangle, fragment.front)?;
            let share = plan.ready.shadow(usize::from(light), point, plane)?;
            Some([share, hole, hole])
        }),
        Aov::Face | Aov::Mesh | Aov::Color => None,
    };
    let channels = aov.channels();
    values
        .filter(|v| v[..channels].iter().all(|v| v.is_finite()))
        .unwrap_or([hole; 3])
}

/// The interpolated normal on the side that is seen.
fn seen_normal(fragment: &Fragment, first: usize) -> [f32; 3] {
    let normal = three(fragment, first);
    if fragment.front {
        normal
    } else {
        normal.map(|x| -x)
    }
}

fn three(fragment: &Fragment, first: usize) -> [f32; 3] {
    [0, 1, 2].map(|k| fragment.values[first + k])
}

fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    (length > 0.0).then(|| v.map(|x| x / length))
}
