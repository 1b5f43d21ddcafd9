//! Typed arrays in the buffers of a document, checked before the first value is read.

use texmap_math::parallel;

use super::json;
use super::model::Model;
use crate::IoError;

/// An accessor whose bytes are all there.
#[derive(Debug)]
pub(super) struct Accessor<'m> {
    model: &'m Model<'m>,
    pointer: String,
    pub(super) count: usize,
    components: usize,
    component: Component,
    normalized: bool,
    /// `None`: zeros.
    bytes: Option<&'m [u8]>,
    /// Bytes from one element to the next.
    stride: usize,
    sparse: Option<Overrides<'m>>,
}

/// Elements that replace those of the buffer.
#[derive(Debug)]
struct Overrides<'m> {
    indices: Vec<u32>,
    /// `None`: zeros.
    values: Option<&'m [u8]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

impl<'m> Model<'m> {
    /// The accessor that `pointer` names.
    pub(super) fn accessor(&'m self, index: usize, pointer: &str) -> Result<Accessor<'m>, IoError> {
        let list = &self.document.accessors;
        let stated = self.item(list, index, pointer, "accessor")?;
        let at = format!("/accessors/{index}");
        let component = Component::of(stated.component_type).ok_or_else(|| {
            self.broken(
                &format!("{at}/componentType"),
                format!("{} is no type of component", stated.component_type),
            )
        })?;
        let components = match stated.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            other => {
                let problem = format!("`{}` is no type that is read here", crate::shortened(other));
                return Err(self.broken(&format!("{at}/type"), problem));
            }
        };
        let Some(count) = u32::try_from(stated.count).ok().filter(|n| *n > 0) else {
            let problem = format!("{} elements; 1 to {} are allowed", stated.count, u32::MAX);
            return Err(self.broken(&format!("{at}/count"), problem));
        };
        let (count, size) = (count as usize, components * component.size());
        let (bytes, stride) = match stated.buffer_view {
            None => (None, size),
            Some(view) => {
                let stride = self
                    .document
                    .buffer_views
                    .get(view)
                    .and_then(|v| v.byte_stride);
                let stride = stride.unwrap_or(size as u64);
                let viewed = self.view(view, &format!("{at}/bufferView"))?;
                (
                    self.elements(viewed, stated.byte_offset, count, stride, size, &at)?,
                    stride as usize,
                )
            }
        };
        let sparse = stated.sparse.as_ref();
        let sparse = sparse
            .map(|sparse| self.overrides(sparse, count, size, &at))
            .transpose()?;
        Ok(Accessor {
            model: self,
            pointer: at,
            count,
            components,
            component,
            normalized: stated.normalized,
            bytes,
            stride,
            sparse,
        })
    }

    /// The bytes from the first to the last of `count` elements of a view.
    fn elements<'v>(
        &self,
        view: Option<&'v [u8]>,
        offset: u64,
        count: usize,
        stride: u64,
        size: usize,
        at: &str,
    ) -> Result<Option<&'v [u8]>, IoError> {
        let Some(view) = view else { return Ok(None) };
        if stride < size as u64 || stride > 1 << 16 {
            return Err(self.broken(
                at,
                format!("elements of {size} bytes do not lie {stride} bytes apart"),
            ));
        }
        // Both factors are below 2^32.
        let length = stride * (count as u64 - 1) + size as u64;
        let end = offset
            .checked_add(length)
            .filter(|end| *end <= view.len() as u64);
        match end {
            Some(end) => Ok(Some(&view[offset as usize..end as usize])),
            None => Err(self.broken(
                at,
                format!(
                    "{count} elements from byte {offset} on need {length} bytes; its view has {}",
                    view.len()
                ),
            )),
        }
    }

    fn overrides(
        &'m self,
        sparse: &json::Sparse,
        count: usize,
        size: usize,
        at: &str,
    ) -> Result<Overrides<'m>, IoError> {
        let changed = sparse.count;
        if changed == 0 || changed > count as u64 {
            let problem = format!("{changed} elements of {count} are replaced");
            return Err(self.broken(&format!("{at}/sparse/count"), problem));
        }
        let changed = changed as usize;
        let at_indices = format!("{at}/sparse/indices");
        let component = Component::of(sparse.indices.component_type)
            .filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
            .ok_or_else(|| {
                self.broken(
                    &format!("{at_indices}/componentType"),
                    "indices are unsigned integers",
                )
            })?;
        let part = |part: &json::SparsePart, size: usize, at: &str| {
            let view = self.view(part.buffer_view, &format!("{at}/bufferView"))?;
            self.elements(view, part.byte_offset, changed, size as u64, size, at)
        };
        let bytes = part(&sparse.indices, component.size(), &at_indices)?;
        let values = part(&sparse.values, size, &format!("{at}/sparse/values"))?;
        self.ask(4 * changed as u64, at)?;
        let indices = match bytes {
            Some(bytes) => whole_numbers::<1>(bytes, component.size(), changed, component),
            None => Vec::new(),
        };
        let indices = indices.into_flattened();
        let rising = indices.windows(2).all(|w| w[0] < w[1]);
        match indices.last() {
            Some(last) if *last as usize >= count || !rising => Err(self.broken(
                &at_indices,
                format!("indices must rise and stay below {count}"),
            )),
            _ => Ok(Overrides { indices, values }),
        }
    }
}

impl Accessor<'_> {
    /// Refuses another number of elements than a list of them must have.
    pub(super) fn expect(&self, count: usize, what: &str) -> Result<(), IoError> {
        match self.count == count {
            true => Ok(()),
            false => Err(self.model.broken(
                &self.pointer,
                format!("{} elements, but there are {count} {what}", self.count),
            )),
        }
    }

    pub(super) fn components(&self) -> usize {
        self.components
    }

    /// Finite numbers, `N` an element; normalized integers are fractions of their largest.
    pub(super) fn floats<const N: usize>(&self) -> Result<Vec<[f32; N]>, IoError> {
        if self.components != N {
            let problem = format!(
                "elements of {} numbers, where {N} are needed",
                self.components
            );
            return Err(self.model.broken(&self.pointer, problem));
        }
        self.model
            .ask(4 * N as u64 * self.count as u64, &self.pointer)?;
        let mut values = match self.bytes {
            Some(bytes) => self.decode(bytes, self.stride, self.count),
            None => vec![[0.0; N]; self.count],
        };
        if let Some(Overrides {
            indices,
            values: Some(bytes),
        }) = &self.sparse
        {
            let replaced = self.decode(bytes, N * self.component.size(), indices.len());
            for (index, value) in indices.iter().zip(replaced) {
                values[*index as usize] = value;
            }
        }
        match parallel::first(values.len(), |i| values[i].iter().any(|x| !x.is_finite())) {
            Some(i) => Err(self
                .model
                .broken(&self.pointer, format!("element {i} is not finite"))),
            None => Ok(values),
        }
    }

    fn decode<const N: usize>(&self, bytes: &[u8], stride: usize, count: usize) -> Vec<[f32; N]> {
        let normalized = self.normalized;
        let signed = move |x: f32, most: f32| if normalized { (x / most).max(-1.0) } else { x };
        let unsigned = move |x: f32, most: f32| if normalized { x / most } else { x };
        match self.component {
            Component::F32 => numbers(bytes, stride, count, f32::from_le_bytes),
            Component::I8 => numbers(bytes, stride, count, |[b]: [u8; 1]| {
                signed(f32::from(b as i8), 127.0)
            }),
            Component::U8 => numbers(bytes, stride, count, |[b]: [u8; 1]| {
                unsigned(f32::from(b), 255.0)
            }),
            Component::I16 => numbers(bytes, stride, count, |b| {
                signed(f32::from(i16::from_le_bytes(b)), 32767.0)
            }),
            Component::U16 => numbers(bytes, stride, count, |b| {
                unsigned(f32::from(u16::from_le_bytes(b)), 65535.0)
            }),
            // No attribute of the standard; as the number that it is.
            Component::U32 => numbers(bytes, stride, count, |b| u32::from_le_bytes(b) as f32),
        }
    }

    /// Whole numbers of one component each, in groups of `N`; those beyond whole groups are left out.
    pub(super) fn indices<const N: usize>(&self) -> Result<Vec<[u32; N]>, IoError> {
        let whole = matches!(
            self.component,
            Component::U8 | Component::U16 | Component::U32
        );
        if self.components != 1 || !whole || self.sparse.is_some() {
            let problem = "indices are plain unsigned integers, one an element";
            return Err(self.model.broken(&self.pointer, problem));
        }
        self.model.ask(4 * self.count as u64, &self.pointer)?;
        Ok(match self.bytes {
            Some(bytes) => whole_numbers(bytes, self.stride, self.count, self.component),
            None => vec![[0; N]; self.count / N],
        })
    }
}

/// Elements of `N` components of `S` bytes each; the last one ends with `bytes`.
fn numbers<const N: usize, const S: usize>(
    bytes: &[u8],
    stride: usize,
    count: usize,
    read: impl Fn([u8; S]) -> f32 + Sync,
) -> Vec<[f32; N]> {
    let element = |i: usize| {
        let element = &bytes[i * stride..][..N * S];
        std::array::from_fn(|n| read(std::array::from_fn(|b| element[n * S + b])))
    };
    parallel::list(count, [0.0; N], element)
}

fn whole_numbers<const N: usize>(
    bytes: &[u8],
    stride: usize,
    count: usize,
    component: Component,
) -> Vec<[u32; N]> {
    fn groups<const N: usize>(count: usize, number: impl Fn(usize) -> u32 + Sync) -> Vec<[u32; N]> {
        let group = |i: usize| std::array::from_fn(|n| number(i * N + n));
        parallel::list(count / N, [0; N], group)
    }
    let at = |i: usize| &bytes[i * stride..];
    match component {
        Component::U16 => groups(count, |i| {
            let b = at(i);
            u16::from_le_bytes([b[0], b[1]]).into()
        }),
        Component::U32 => groups(count, |i| {
            let b = at(i);
            u32::from_le_bytes([b[0], b[1], b[2], b[3]])
        }),
        _ => groups(count, |i| at(i)[0].into()),
    }
}
