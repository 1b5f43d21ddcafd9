//! The parts of a glTF file: typed arrays and pictures in one buffer, and the two containers.

use serde_json::{Value, json};

/// A buffer that grows, with the views and accessors into it.
#[derive(Default)]
pub(crate) struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Index of a view of these bytes.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views
            .push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        self.views.len() - 1
    }

    /// Says that the elements of a view begin `stride` bytes apart.
    pub(crate) fn set_stride(&mut self, view: usize, stride: usize) {
        self.views[view]["byteStride"] = stride.into();
    }

    /// Index of an accessor with these properties.
    pub(crate) fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Index of an accessor of vectors of `N` floats, with its least and largest values.
    pub(crate) fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let view = self.view(&bytes);
        let kind = match N {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        let fold = |f: fn(f32, f32) -> f32| -> Vec<f32> {
            let all = values.iter().copied();
            let least = all.reduce(|a, b| std::array::from_fn(|i| f(a[i], b[i])));
            least.map_or_else(Vec::new, |v| v.to_vec())
        };
        self.accessor(json!({
            "bufferView": view, "componentType": 5126, "count": values.len(), "type": kind,
            "min": fold(f32::min), "max": fold(f32::max),
        }))
    }

    /// Index of an accessor of 16-bit indices.
    pub(crate) fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.accessor(json!({"bufferView": view, "componentType": 5123, "count": indices.len(), "type": "SCALAR"}))
    }

    /// The document with what lies in the buffer, and the bytes. `uri` names the buffer.
    pub(crate) fn document(mut self, mut document: Value, uri: Option<&str>) -> (String, Vec<u8>) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        document["asset"] = json!({"version": "2.0", "generator": "texmap-assets"});
        let mut buffer = json!({"byteLength": self.bytes.len()});
        if let Some(uri) = uri {
            buffer["uri"] = uri.into();
        }
        document["buffers"] = json!([buffer]);
        document["bufferViews"] = self.views.into();
        document["accessors"] = self.accessors.into();
        (document.to_string(), self.bytes)
    }

    /// The document as a GLB.
    pub(crate) fn glb(self, document: Value) -> Vec<u8> {
        let (json, bytes) = self.document(document, None);
        let mut json = json.into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + json.len() + 8 + bytes.len();
        let word = |x: usize| (x as u32).to_le_bytes();
        let mut out = b"glTF".to_vec();
        out.extend(word(2));
        out.extend(word(length));
        out.extend(word(json.len()));
        out.extend(b"JSON");
        out.extend(json);
        out.extend(word(bytes.len()));
        out.extend(b"BIN\0");
        out.extend(bytes);
        out
    }

    /// The document as JSON that holds its bytes.
    pub(crate) fn embedded(self, document: Value) -> Vec<u8> {
        let bytes = {
            let mut bytes = self.bytes.clone();
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            bytes
        };
        let uri = format!("data:application/octet-stream;base64,{}", base64(&bytes));
        self.document(document, Some(&uri)).0.into_bytes()
    }
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let word = at(0) << 16 | at(1) << 8 | at(2);
        for i in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * i) & 63) as usize];
            out.push(if i <= three.len() { digit.into() } else { '=' });
        }
    }
    out
}
