//! The place in a JSON text that a parser stopped at, as a pointer (RFC 6901 without its escapes): found for a fault alone, so that
//! reading keeps no track of it.

/// A list or object that is open at the place.
enum Open<'a> {
    List(usize),
    /// The last name that was read.
    Object(&'a str),
}

/// The pointer to the value at `line` and `column` of a text, both counted from 1 in bytes, as `serde_json` tells them: the value that ends
/// there, or that begins there with a bracket. Empty for the text as a whole.
pub(super) fn pointer_at(json: &[u8], line: usize, column: usize) -> String {
    let before: usize = json
        .split_inclusive(|byte| *byte == b'\n')
        .take(line.saturating_sub(1))
        .map(<[u8]>::len)
        .sum();
    let read = &json[..(before + column).min(json.len())];
    // A bracket that does not belong here is that of the value itself.
    let read = match read {
        [read @ .., b'[' | b'{'] => read,
        read => read,
    };
    let mut open = Vec::new();
    let (mut at, mut name) = (0, "");
    while let Some(byte) = read.get(at) {
        at += 1;
        match byte {
            b'"' => {
                let from = at;
                while read.get(at).is_some_and(|byte| *byte != b'"') {
                    at += if read[at] == b'\\' { 2 } else { 1 };
                }
                let text = read.get(from..at).unwrap_or_default();
                name = str::from_utf8(text).unwrap_or("?");
                at += 1;
            }
            b':' => {
                if let Some(Open::Object(key)) = open.last_mut() {
                    *key = name;
                }
            }
            b',' => match open.last_mut() {
                Some(Open::List(index)) => *index += 1,
                Some(Open::Object(key)) => *key = "",
                None => {}
            },
            b'[' => open.push(Open::List(0)),
            b'{' => open.push(Open::Object("")),
            b']' | b'}' => {
                open.pop();
            }
            _ => {}
        }
    }
    let mut pointer = String::new();
    for step in open {
        match step {
            Open::List(index) => pointer += &format!("/{index}"),
            Open::Object("") => {}
            Open::Object(key) => {
                pointer.push('/');
                pointer += key;
            }
        }
    }
    pointer
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of<T: serde::de::DeserializeOwned>(json: &str) -> String {
        let error = serde_json::from_str::<T>(json).err().unwrap();
        pointer_at(json.as_bytes(), error.line(), error.column())
    }

    #[derive(serde::Deserialize)]
    #[expect(dead_code, reason = "read by its type alone")]
    struct Part {
        size: u32,
        #[serde(default)]
        name: String,
        #[serde(default)]
        parts: Vec<Self>,
    }

    #[test]
    fn values_of_a_wrong_kind_are_named() {
        assert_eq!(of::<Part>(r#"{"size": "x"}"#), "/size");
        assert_eq!(of::<Part>("{\n \"size\": 1,\n \"name\": 7 }"), "/name");
        for wrong in ["-1", "[1]", "{}", "null", "\"\\\"]\"", "1.5"] {
            let json = format!(
                r#"{{"size": 1, "name": "a\\\"[,{{", "parts": [{{"size": 2}}, {{"size": {wrong}}}]}}"#
            );
            assert_eq!(of::<Part>(&json), "/parts/1/size", "{wrong}");
        }
    }

    #[test]
    fn an_object_that_lacks_a_member_is_named() {
        assert_eq!(
            of::<Part>(r#"{"size": 1, "parts": [{"size": 1}, {"name": "b"}]}"#),
            "/parts/1"
        );
        assert_eq!(of::<Part>("{}"), "");
    }

    #[test]
    fn broken_text_has_the_place_of_its_fault() {
        assert_eq!(of::<Part>(r#"{"size": 1} x"#), "");
        assert_eq!(
            of::<Part>(r#"{"size": 1, "parts": [{"size": 1"#),
            "/parts/0/size"
        );
        assert_eq!(of::<Part>(r#"{"size": 1, "name": "abc"#), "/name");
        assert_eq!(pointer_at(b"", 0, 0), "");
        assert_eq!(pointer_at(b"\xff\"\\", 7, 9), "");
    }
}
