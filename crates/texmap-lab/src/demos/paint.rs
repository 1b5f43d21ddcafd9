//! The demos' textures, painted in code so that the program needs no files: a checker, a lettered grid, a
//! brick wall, a cow's face as photo and a lattice with holes.

use texmap_truth::picture::{Picture, Rgba};

/// A checkerboard of `cells` by `cells` fields on `size` by `size` texels.
pub(super) fn checker(size: u32, cells: u32, dark: Rgba, light: Rgba) -> Picture {
    let cell = (size / cells).max(1);
    Picture::from_fn(size, size, |x, y| {
        if (x / cell + y / cell).is_multiple_of(2) {
            light
        } else {
            dark
        }
    })
}

/// Four by four fields lettered A1 (top left) to D4. Shows at a glance where a texture lies and which way up.
pub(super) fn letters(size: u32) -> Picture {
    let cell = size / 4;
    let mut picture = Picture::from_fn(size, size, |x, y| {
        let edge = x > 0 && x % cell == 0 || y > 0 && y % cell == 0;
        if edge {
            [40, 40, 48, 255]
        } else {
            field((x / cell).min(3), (y / cell).min(3))
        }
    });
    let scale = (cell / 24).max(1);
    for row in 0..4u32 {
        for column in 0..4u32 {
            let text = format!("{}{}", char::from(b'A' + column as u8), row + 1);
            let left = i64::from(column * cell + (cell.saturating_sub(16 * scale)) / 2);
            let top = i64::from(row * cell + (cell.saturating_sub(16 * scale)) / 2);
            picture.text(left, top, scale, [255, 255, 255, 255], &text);
        }
    }
    picture
}

/// The colour of a field of the lettered grid.
pub(super) fn field(column: u32, row: u32) -> Rgba {
    let hue = [
        [232, 106, 88],
        [240, 178, 74],
        [94, 170, 120],
        [84, 140, 200],
    ][column as usize % 4];
    let shade = if (column + row).is_multiple_of(2) {
        100
    } else {
        78
    };
    let tone = |c: u32| (c * shade / 100 + 12 * row).min(255) as u8;
    [tone(hue[0]), tone(hue[1]), tone(hue[2]), 255]
}

/// Bricks in running bond: 4 by 8 courses, each brick of its own tint, mortar between.
pub(super) fn bricks(size: u32) -> Picture {
    let (brick, course) = (size / 4, size / 8);
    let joint = (size / 64).max(1);
    Picture::from_fn(size, size, |x, y| {
        let row = y / course;
        let shifted = (x + if row % 2 == 1 { brick / 2 } else { 0 }) % size;
        let mortar = shifted % brick < joint || y % course < joint;
        let grain = (hash(x, y) >> 28) as u8;
        if mortar {
            return [196 + grain / 2, 190 + grain / 2, 180 + grain / 2, 255];
        }
        let tint = (hash(shifted / brick + 17, row + 91) >> 27) as u8;
        [
            150 + tint + grain / 2,
            66 + tint / 2 + grain / 2,
            50 + tint / 3 + grain / 2,
            255,
        ]
    })
}

/// A lattice of crossed slats with holes (alpha 0) between them. The hidden colour of the holes is a glaring
/// green, so that a fringe of it would be seen.
pub(super) fn lattice(size: u32) -> Picture {
    let period = (size / 4) as i64;
    let slat = period * 5 / 16;
    Picture::from_fn(size, size, |x, y| {
        let (x, y) = (i64::from(x), i64::from(y));
        let rising = (x + y).rem_euclid(period);
        let falling = (x - y).rem_euclid(period);
        let over = ((x + y).div_euclid(period) + (x - y).div_euclid(period)) % 2 == 0;
        let wood = |across: i64| {
            let round = 255 - (2 * across - slat).abs() * 90 / slat;
            let tone = |c: i64| (c * round / 255).clamp(0, 255) as u8;
            [tone(206), tone(158), tone(98), 255]
        };
        match (rising < slat, falling < slat) {
            (true, true) => wood(if over { rising } else { falling }),
            (true, false) => wood(rising),
            (false, true) => wood(falling),
            (false, false) => [0, 255, 0, 0],
        }
    })
}

/// A purple cow looking out of a round window, with a frame of straight lines that shows any bend.
pub(super) fn cow_photo(size: u32) -> Picture {
    Picture::from_fn(size, size, |x, y| {
        let mut sum = [0u32; 3];
        for (dx, dy) in [(1, 1), (3, 1), (1, 3), (3, 3)] {
            let at = |v: u32, d: u32| ((v * 4 + d) * 1000) as i64 / (i64::from(size) * 4);
            let color = cow(at(x, dx), at(y, dy));
            for (total, c) in sum.iter_mut().zip(color) {
                *total += u32::from(c);
            }
        }
        [
            (sum[0] / 4) as u8,
            (sum[1] / 4) as u8,
            (sum[2] / 4) as u8,
            255,
        ]
    })
}

/// The cow in thousandths of the picture; integers, so that the picture has the same bytes everywhere.
fn cow(x: i64, y: i64) -> [u8; 3] {
    // The face is symmetric about x = 500.
    let side = (x - 500).abs();
    let ellipse = |cx: i64, cy: i64, rx: i64, ry: i64| {
        let (dx, dy) = ((side - cx) * 1000 / rx, (y - cy) * 1000 / ry);
        dx * dx + dy * dy <= 1_000_000
    };
    if x.min(y).min(1000 - x).min(1000 - y) < 40 {
        return if (x / 50 + y / 50) % 2 == 0 {
            [245, 240, 225]
        } else {
            [70, 60, 80]
        };
    }
    if ellipse(58, 700, 26, 18) {
        return [88, 30, 62];
    }
    if ellipse(0, 715, 190, 115) {
        return if y > 758 && y < 768 && side < 90 {
            [150, 74, 110]
        } else {
            [242, 186, 202]
        };
    }
    if ellipse(105, 445, 20, 26) {
        return [20, 18, 28];
    }
    if ellipse(100, 450, 48, 56) {
        return [252, 252, 250];
    }
    let patch = (x - 640) * (x - 640) + (y - 340) * (y - 340) < 110 * 110;
    if ellipse(0, 500, 220, 330) {
        return if patch { [98, 44, 140] } else { [154, 84, 200] };
    }
    if ellipse(285, 330, 95, 52) {
        return if ellipse(285, 335, 60, 28) {
            [236, 170, 196]
        } else {
            [128, 62, 172]
        };
    }
    if ellipse(170, 190, 42, 95) {
        return [238, 226, 190];
    }
    if y > 800 {
        let blade = (x * 7 + y * 13) % 60 < 18;
        return if blade { [72, 140, 62] } else { [96, 168, 78] };
    }
    let haze = (y / 12).clamp(0, 66) as u8;
    [128 + haze, 178 + haze, 236]
}

/// A well-mixed hash of a texel position (the finalizer of MurmurHash3, Appleby 2011).
fn hash(x: u32, y: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}
