use core::fmt;

/// Error of a texture or a batch that is refused. Every variant carries the numbers that were wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SampleError {
    /// A side is zero or above [`MAX_SIDE`](crate::Texture2d::MAX_SIDE).
    Size {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
    },
    /// The chain would need more than 2^30 words, the reach of the gather indices.
    TooLarge {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
    },
    /// A texel has 1 to 4 channels.
    Channels(u32),
    /// An image of blocks has one level or more, and no more than halving gives.
    Levels {
        /// Levels given.
        levels: usize,
        /// Most that the size allows.
        most: usize,
    },
    /// The slice does not hold `width * height * channels` values.
    Length {
        /// Values the size asks for.
        expected: usize,
        /// Values given.
        got: usize,
    },
    /// A float texel is NaN, infinite or beyond +-2^120, as it is or decoded and premultiplied.
    Texel {
        /// Column of the texel.
        x: u32,
        /// Row of the texel, in the order of the slice.
        y: u32,
    },
    /// A palette index names no entry.
    PaletteIndex {
        /// Column of the texel.
        x: u32,
        /// Row of the texel, in the order of the slice.
        y: u32,
        /// The index found.
        index: u8,
        /// Entries in the palette.
        entries: usize,
    },
    /// A ray cannot walk through a volume by these numbers.
    March {
        /// Extinction asked for.
        density: f32,
        /// Step asked for.
        step: f32,
    },
    /// Slices of one batch differ in length.
    Mismatch {
        /// Name of the slice.
        what: &'static str,
        /// Length of the coordinates.
        expected: usize,
        /// Length given.
        got: usize,
    },
    /// Textures that are looked up together have other numbers of outputs.
    Outputs {
        /// The textures.
        textures: usize,
        /// Outputs given.
        got: usize,
    },
}

impl fmt::Display for SampleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Size { width, height } => write!(
                f,
                "texture size {width}x{height} is out of range: each side must be 1 to {}",
                crate::Texture2d::MAX_SIDE
            ),
            Self::TooLarge { width, height } => write!(
                f,
                "texture {width}x{height} with its mip chain exceeds 2^30 words: use a smaller size or fewer bits a channel"
            ),
            Self::Levels { levels, most } => write!(
                f,
                "{levels} mip levels: an image of this size has 1 to {most}"
            ),
            Self::Channels(n) => write!(f, "{n} channels a texel: give 1, 2, 3 or 4"),
            Self::Length { expected, got } => {
                write!(
                    f,
                    "texel slice holds {got} values, the size asks for {expected}"
                )
            }
            Self::Texel { x, y } => write!(
                f,
                "texel ({x}, {y}) is not a finite number within 2^120: replace NaN and infinities first"
            ),
            Self::PaletteIndex {
                x,
                y,
                index,
                entries,
            } => write!(
                f,
                "texel ({x}, {y}) has palette index {index}, the palette has {entries} entries"
            ),
            Self::March { density, step } => write!(
                f,
                "a volume of density {density} in steps of {step}: give a density of 0 or more and a step above 0, both finite"
            ),
            Self::Mismatch {
                what,
                expected,
                got,
            } => {
                write!(
                    f,
                    "{what} holds {got} entries, the coordinates have {expected}"
                )
            }
            Self::Outputs { textures, got } => {
                write!(
                    f,
                    "{got} sets of columns for {textures} textures: give one for each"
                )
            }
        }
    }
}

impl core::error::Error for SampleError {}
