//! Bytes as choices.

/// Bytes as choices; zeros when they run out.
pub(super) struct Choices<'a>(pub(super) &'a [u8]);

impl Choices<'_> {
    pub(super) fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        *first
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n
    }

    pub(super) fn number(&mut self) -> f32 {
        const SPECIAL: [f32; 16] = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.5,
            1e-45,
            f32::MIN_POSITIVE,
            1e-20,
            1e20,
            3e4,
            -3e4,
            f32::MAX,
            f32::MIN,
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
        ];
        match self.byte() {
            kind @ 0..16 => SPECIAL[usize::from(kind)],
            16..32 => f32::from_bits(u32::from_le_bytes([0; 4].map(|_: u8| self.byte()))),
            _ => f32::from(i16::from_le_bytes([self.byte(), self.byte()])) / 8192.0,
        }
    }

    /// `N` numbers.
    pub(super) fn numbers<const N: usize>(&mut self) -> [f32; N] {
        [0; N].map(|_| self.number())
    }

    /// Numbers within `-8..8`, but for a special one at times.
    pub(super) fn tame<const N: usize>(&mut self) -> [f32; N] {
        [0; N].map(|_| {
            let number = self.number();
            if number.abs() <= 8.0 || self.byte() > 250 {
                number
            } else {
                1.0
            }
        })
    }

    pub(super) fn of<T: Copy>(&mut self, among: &[T]) -> T {
        among[self.below(among.len())]
    }
}
