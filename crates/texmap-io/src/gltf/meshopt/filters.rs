//! Filters: transforms of elements after decoding.

/// A filter, by the kind of its elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    /// Unit vectors on an octahedron, of 8 or 16 bits a component.
    Octahedral,
    /// Unit quaternions without their largest component.
    Quaternion,
    /// Floats as whole numbers of 24 bits times powers of two.
    Exponential,
    /// Colours as luma, two differences and alpha, of 8 or 16 bits a component.
    Color,
}

impl Filter {
    pub(super) fn named(name: &str) -> Option<Self> {
        match name {
            "OCTAHEDRAL" => Some(Self::Octahedral),
            "QUATERNION" => Some(Self::Quaternion),
            "EXPONENTIAL" => Some(Self::Exponential),
            "COLOR" => Some(Self::Color),
            _ => None,
        }
    }

    /// True if it goes with attributes of so many bytes.
    pub(super) fn fits(self, stride: usize) -> bool {
        match self {
            Self::Octahedral | Self::Color => stride == 4 || stride == 8,
            Self::Quaternion => stride == 8,
            Self::Exponential => true,
        }
    }

    /// In place.
    pub(super) fn decode(self, bytes: &mut [u8], stride: usize) {
        match (self, stride) {
            (Self::Octahedral, 4) => each8(bytes, |[x, y, one, w]| {
                let signed = |c: u8| i32::from(c.cast_signed());
                let [x, y, z] = octahedral([signed(x), signed(y), signed(one)], 127.0);
                [x as u8, y as u8, z as u8, w]
            }),
            (Self::Octahedral, _) => each16(bytes, |[x, y, one, w]| {
                let [x, y, z] = octahedral([x, y, one].map(signed16), 32767.0);
                [x as u16, y as u16, z as u16, w]
            }),
            (Self::Quaternion, _) => each16(bytes, quaternion),
            (Self::Exponential, _) => {
                for word in bytes.as_chunks_mut().0 {
                    *word = exponential(i32::from_le_bytes(*word)).to_le_bytes();
                }
            }
            (Self::Color, 4) => each8(bytes, |[y, co, cg, a]| {
                let signed = |c: u8| i32::from(c.cast_signed());
                color([y.into(), signed(co), signed(cg), a.into()], 255.0).map(|c| c as u8)
            }),
            (Self::Color, _) => each16(bytes, |[y, co, cg, a]| {
                color([y.into(), signed16(co), signed16(cg), a.into()], 65535.0).map(|c| c as u16)
            }),
        }
    }
}

fn each8(bytes: &mut [u8], decode: impl Fn([u8; 4]) -> [u8; 4]) {
    for element in bytes.as_chunks_mut().0 {
        *element = decode(*element);
    }
}

fn each16(bytes: &mut [u8], decode: impl Fn([u16; 4]) -> [u16; 4]) {
    for element in bytes.as_chunks_mut::<8>().0 {
        let (halves, _) = element.as_chunks();
        let decoded = decode([0, 1, 2, 3].map(|k| u16::from_le_bytes(halves[k])));
        for (bytes, half) in element.as_chunks_mut().0.iter_mut().zip(decoded) {
            *bytes = half.to_le_bytes();
        }
    }
}

fn signed16(c: u16) -> i32 {
    i32::from(c.cast_signed())
}

/// A unit vector in steps of 1 / `most`, from its place on an octahedron; the third component is the place's 1.
fn octahedral([x, y, one]: [i32; 3], most: f32) -> [i32; 3] {
    let one = one as f32;
    let (x, y) = (x as f32 / one, y as f32 / one);
    let z = 1.0 - x.abs() - y.abs();
    // The lower half is folded out.
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let length = (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|c| (c / length * most).round() as i32)
}

/// The bits of a quaternion of 16-bit components.
fn quaternion([x, y, z, last]: [u16; 4]) -> [u16; 4] {
    // The largest of the others is 1 / sqrt(2).
    let one = (signed16(last) | 3) as f32;
    let part = |c: u16| signed16(c) as f32 / one * core::f32::consts::FRAC_1_SQRT_2;
    let [x, y, z] = [x, y, z].map(part);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let largest = usize::from(last & 3);
    let mut out = [0; 4];
    for (k, c) in [w, x, y, z].into_iter().enumerate() {
        out[(largest + k) % 4] = (c * 32767.0).round() as i32 as u16;
    }
    out
}

/// `m 2^e` of the low 24 bits and the high 8; an exponent beyond those of floats is the nearest one.
fn exponential(word: i32) -> f32 {
    let (e, m) = ((word >> 24).clamp(-126, 127), (word << 8) >> 8);
    f32::from_bits(((e + 127) as u32) << 23) * m as f32
}

/// Red, green, blue and alpha in steps of 1 / `most`.
fn color([y, co, cg, a]: [i32; 4], most: f32) -> [i32; 4] {
    // Alpha is one bit shorter than the others, below a bit that is set.
    let all = match a {
        0 => 1,
        _ => (1 << (a.ilog2() + 1)) - 1,
    };
    let alpha = a & (all >> 1);
    let alpha = alpha << 1 | alpha & 1;
    let scale = most / all as f32;
    [y + co - cg, y + cg, y - co - cg, alpha]
        .map(|c| (c as f32 * scale).round().clamp(0.0, most) as i32)
}
