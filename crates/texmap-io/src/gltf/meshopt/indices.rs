//! Indices: triangles by the edges and vertices that they share with earlier ones, and sequences by differences.

use super::{Reader, body};

/// `count` indices of triangles in `stride` bytes each, 2 or 4.
pub(super) fn triangles(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    let (_, mut reader, table) = body(bytes, &[0xe1], |_| 16)?;
    let valid = |pair: &u8| pair >> 4 != 15 && pair & 15 != 15;
    if table[14..] != [0, 0] || !table.iter().all(valid) {
        return Err("the table of the stream is broken".to_owned());
    }
    let codes = reader.take(count / 3)?;
    let mut state = Triangles {
        reader,
        next: 0,
        last: 0,
        edges: Recent::default(),
        vertices: Recent::default(),
    };
    let mut out = Indices::new(count, stride);
    for code in codes {
        for index in state.triangle(*code, table)? {
            out.push(index);
        }
    }
    state.reader.finish()?;
    Ok(out.bytes)
}

/// `count` indices in `stride` bytes each, 2 or 4, as differences from one of two earlier ones.
pub(super) fn sequence(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    let (_, mut reader, _) = body(bytes, &[0xd1], |_| 4)?;
    let mut last = [0_u32; 2];
    let mut out = Indices::new(count, stride);
    for _ in 0..count {
        let code = number(&mut reader)?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(signed(code >> 1));
        out.push(*last);
    }
    reader.finish()?;
    Ok(out.bytes)
}

/// Indices as bytes.
struct Indices {
    bytes: Vec<u8>,
    stride: usize,
}

impl Indices {
    fn new(count: usize, stride: usize) -> Self {
        Self {
            bytes: Vec::with_capacity(count * stride),
            stride,
        }
    }

    fn push(&mut self, index: u32) {
        let bytes = index.to_le_bytes();
        self.bytes.extend_from_slice(&bytes[..self.stride]);
    }
}

/// The sixteen last items of a kind.
#[derive(Default)]
struct Recent<T> {
    items: [T; 16],
    pushed: usize,
}

impl<T: Copy> Recent<T> {
    fn push(&mut self, item: T) {
        self.items[self.pushed % 16] = item;
        self.pushed += 1;
    }

    /// The `back`-th but the latest.
    fn get(&self, back: u8) -> Result<T, String> {
        let at = self.pushed.checked_sub(1 + usize::from(back));
        let at = at.ok_or("a triangle shares a vertex or an edge that there was not")?;
        Ok(self.items[at % 16])
    }
}

struct Triangles<'a> {
    reader: Reader<'a>,
    /// The first index that was not used yet.
    next: u32,
    /// The last index that was stated.
    last: u32,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
}

impl Triangles<'_> {
    fn triangle(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], String> {
        match code {
            0xf0..=0xfd => {
                let a = self.unused();
                self.apart(a, table[usize::from(code & 15)])
            }
            0xfe.. => {
                let pair = self.reader.byte()?;
                if pair == 0 {
                    self.next = 0;
                }
                let a = match code {
                    0xfe => self.unused(),
                    _ => self.stated()?,
                };
                self.apart(a, pair)
            }
            _ => self.beside(code >> 4, code & 15),
        }
    }

    /// A triangle on an edge of an earlier one.
    fn beside(&mut self, edge: u8, third: u8) -> Result<[u32; 3], String> {
        let [a, b] = self.edges.get(edge)?;
        let c = match third {
            0 => self.unused(),
            13 | 14 => {
                self.last = match third {
                    13 => self.last.wrapping_sub(1),
                    _ => self.last.wrapping_add(1),
                };
                self.last
            }
            15 => self.stated()?,
            _ => self.vertices.get(third)?,
        };
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        if !(1..13).contains(&third) {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }

    /// A triangle on no earlier edge. A half of `pair` is 0 for an unused vertex, 15 for a stated one, else an earlier one.
    fn apart(&mut self, a: u32, pair: u8) -> Result<[u32; 3], String> {
        let halves = [pair >> 4, pair & 15];
        let mut others = [0; 2];
        for (other, half) in others.iter_mut().zip(halves) {
            *other = match half {
                0 => self.unused(),
                15 => self.stated()?,
                _ => self.vertices.get(half - 1)?,
            };
        }
        let [b, c] = others;
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        self.vertices.push(a);
        for (other, half) in others.into_iter().zip(halves) {
            if half == 0 || half == 15 {
                self.vertices.push(other);
            }
        }
        Ok([a, b, c])
    }

    fn unused(&mut self) -> u32 {
        let index = self.next;
        self.next = index.wrapping_add(1);
        index
    }

    fn stated(&mut self) -> Result<u32, String> {
        let difference = signed(number(&mut self.reader)?);
        self.last = self.last.wrapping_add(difference);
        Ok(self.last)
    }
}

/// Seven bits a byte, the lowest first; the highest bit of a byte is set if more follow, at most five.
fn number(reader: &mut Reader<'_>) -> Result<u32, String> {
    let mut value = 0;
    for shift in (0..35).step_by(7) {
        let byte = reader.byte()?;
        value |= u32::from(byte & 127) << shift;
        if byte < 128 {
            return Ok(value);
        }
    }
    Err("an index of the stream does not end".to_owned())
}

/// The sign of a difference is its lowest bit.
fn signed(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}
