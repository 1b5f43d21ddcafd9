//! Positions of the records of an element in a body of bytes.

use texmap_math::parallel;

use super::header::{Element, Property};

/// The records of an element, all of them within the body.
#[derive(Debug)]
pub(super) struct Records<'a> {
    body: &'a [u8],
    big: bool,
    pub(super) element: &'a Element,
    starts: Starts,
    /// The byte after the last record.
    pub(super) end: usize,
}

#[derive(Debug)]
enum Starts {
    /// The lists of all records are as long as those of the first one.
    Even {
        first: usize,
        stride: usize,
    },
    Each(Vec<u32>),
}

/// The number of a faulty record, the byte where it begins, and the description of the fault.
pub(super) type Fault = (usize, usize, &'static str);

const SHORT: &str = "is cut off: the file ends within it";

impl<'a> Records<'a> {
    /// Finds the records of an element that begin at a byte of the body.
    pub(super) fn find(
        body: &'a [u8],
        big: bool,
        element: &'a Element,
        first: usize,
    ) -> Result<Self, Fault> {
        let mut records = Self {
            body,
            big,
            element,
            starts: Starts::Even { first, stride: 0 },
            end: first,
        };
        if element.count == 0 || element.properties.is_empty() {
            return Ok(records);
        }
        let end = records.after(first);
        let stride = end.map_err(|problem| (0, first, problem))? - first;
        records.starts = Starts::Even { first, stride };
        let lists = element.properties.iter().any(|p| p.list.is_some());
        let fitting = (body.len() - first) / stride;
        if fitting >= element.count && (!lists || records.are_alike()) {
            records.end = first + stride * element.count;
        } else if lists {
            let mut starts = Vec::new();
            for record in 0..element.count {
                let start = records.end;
                starts.push(start as u32);
                let end = records.after(start);
                records.end = end.map_err(|problem| (record, start, problem))?;
            }
            records.starts = Starts::Each(starts);
        } else {
            return Err((fitting, first + stride * fitting, SHORT));
        }
        Ok(records)
    }

    /// The byte after the record at this byte.
    fn after(&self, mut at: usize) -> Result<usize, &'static str> {
        for property in &self.element.properties {
            let (values, count) = self.values(at, property)?;
            let end = (count as usize).checked_mul(property.kind.size());
            at = (end.and_then(|size| size.checked_add(values)))
                .filter(|end| *end <= self.body.len())
                .ok_or(SHORT)?;
        }
        Ok(at)
    }

    /// The byte of the first value of a property that begins at a byte, and the number of its values.
    #[inline]
    fn values(&self, at: usize, property: &Property) -> Result<(usize, u32), &'static str> {
        let Some(list) = property.list else {
            return Ok((at, 1));
        };
        let length = self
            .body
            .get(at..)
            .and_then(|rest| list.read(rest, self.big));
        let length = length.ok_or(SHORT)?;
        match length < 0.0 {
            true => Err("has a list of negative length"),
            false => Ok((at + list.size(), length as u32)),
        }
    }

    /// True if each record has as many values in its lists as the first one.
    fn are_alike(&self) -> bool {
        let mut at = self.start(0);
        self.element.properties.iter().all(|property| {
            let Ok((values, count)) = self.values(at, property) else {
                return false;
            };
            let offset = at - self.start(0);
            at = values + count as usize * property.kind.size();
            property.list.is_none()
                || parallel::first(self.element.count, |record| {
                    !self
                        .values(self.start(record) + offset, property)
                        .is_ok_and(|(_, found)| found == count)
                })
                .is_none()
        })
    }

    /// The byte where a record begins.
    #[inline]
    pub(super) fn start(&self, record: usize) -> usize {
        match &self.starts {
            Starts::Even { first, stride } => first + stride * record,
            Starts::Each(starts) => starts[record] as usize,
        }
    }

    /// The property of one of these names.
    pub(super) fn field(&self, names: &[&str]) -> Option<Field<'_>> {
        let properties = &self.element.properties;
        let number = properties
            .iter()
            .position(|p| names.contains(&p.name.as_str()))?;
        let (before, rest) = properties.split_at(number);
        let alone = before.iter().all(|p| p.list.is_none());
        Some(Field {
            records: self,
            before,
            property: &rest[0],
            offset: alone.then(|| before.iter().map(|p| p.kind.size()).sum()),
        })
    }
}

/// A property of all records.
#[derive(Debug, Clone, Copy)]
pub(super) struct Field<'a> {
    records: &'a Records<'a>,
    before: &'a [Property],
    pub(super) property: &'a Property,
    /// Bytes before it in a record, unless there is a list.
    offset: Option<usize>,
}

impl<'a> Field<'a> {
    /// The value in a record of a property that is no list.
    #[inline]
    pub(super) fn value(&self, record: usize) -> f64 {
        let bytes = &self.records.body[self.at(record)..];
        let value = self.property.kind.read(bytes, self.records.big);
        value.unwrap_or(f64::NAN)
    }

    /// The values of the list in a record.
    #[inline]
    pub(super) fn list(&self, record: usize) -> impl ExactSizeIterator<Item = f64> + use<'a> {
        let Records { body, big, .. } = *self.records;
        let (kind, at) = (self.property.kind, self.at(record));
        let (values, count) = self.records.values(at, self.property).unwrap_or((at, 0));
        let bytes = &body[values..][..count as usize * kind.size()];
        let values = bytes.chunks_exact(kind.size());
        values.map(move |value| kind.read(value, big).unwrap_or(f64::NAN))
    }

    /// The byte where the property begins in a record.
    fn at(&self, record: usize) -> usize {
        let start = self.records.start(record);
        if let Some(offset) = self.offset {
            return start + offset;
        }
        self.before.iter().fold(start, |at, before| {
            let (values, count) = self.records.values(at, before).unwrap_or((at, 0));
            values + count as usize * before.kind.size()
        })
    }
}
