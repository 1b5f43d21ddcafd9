//! Streams by hand; `tests/suite/io/gltf/compressed.rs` has those of an encoder.

use super::*;

fn attributes(bytes: &[u8], count: usize) -> Result<Vec<u8>, String> {
    attributes::decode(bytes, count, 4)
}

/// The example of the text of `KHR_meshopt_compression`, as the first byte of elements; the other bytes are 0.
#[test]
fn differences_that_do_not_fit_stand_behind_their_group() {
    let mut stream = vec![0xa0, 2];
    stream.extend([0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5]);
    stream.extend([0; 3]);
    stream.extend([0; 32]);
    let differences = [
        -1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0_i32,
    ];
    let mut sum = 0_i32;
    let expected = differences.map(|d| {
        sum += d;
        [sum as u8, 0, 0, 0]
    });
    assert_eq!(attributes(&stream, 16).unwrap(), expected.as_flattened());
    // The first element is relative to that of the tail.
    let baseline = stream.len() - 4;
    stream[baseline] = 3;
    let from_three = expected.map(|[a, ..]| [a.wrapping_add(3), 0, 0, 0]);
    assert_eq!(attributes(&stream, 16).unwrap(), from_three.as_flattened());
    // Only as many elements as asked for, of whole groups.
    assert_eq!(
        attributes(&stream, 9).unwrap(),
        from_three[..9].as_flattened()
    );
    assert!(attributes(&stream, 80).is_err());
}

#[test]
fn newer_streams_have_differences_of_two_and_four_bytes() {
    // All four bytes as they are, of two elements: the differences 1 and 2.
    let stream = |mode: u8| {
        let literals = [2, 4, 1, 0, 0, 0, 0, 0];
        let mut stream = vec![0xa1, 0xff];
        stream.extend(literals);
        stream.extend([0; 19]);
        stream.extend([10, 0, 0, 0, mode]);
        attributes(&stream, 2)
    };
    assert_eq!(stream(0).unwrap(), [11, 255, 0, 0, 13, 255, 0, 0]);
    // 0x0102 and 0x0004, of which the lowest bit is the sign.
    assert_eq!(
        stream(1).unwrap(),
        [10 + 129, 0, 0, 0, 10 + 129 + 2, 0, 0, 0]
    );
    assert_eq!(stream(2).unwrap(), [10 ^ 2, 1, 0, 0, 10 ^ 2 ^ 4, 1, 0, 0]);
    assert_eq!(stream(0x12).unwrap()[..4], [10 ^ 0x81, 0, 0, 0]);
    assert_eq!(stream(3).unwrap_err(), "there is no channel mode 0x03");
    assert_eq!(stream(0x10).unwrap_err(), "there is no channel mode 0x10");
}

/// Two triangles of a square, then one that shares a vertex that there was not.
#[test]
fn triangles_share_edges_of_those_before() {
    let stream = |codes: [u8; 2]| {
        let mut stream = vec![0xe1];
        stream.extend(codes);
        stream.extend([0; 16]);
        indices::triangles(&stream, 6, 2)
    };
    // Three new vertices; then edge (c, b) of the first, the second last of those kept, and a new vertex.
    let found = stream([0xf0, 0x10]).unwrap();
    assert_eq!(found, [0, 0, 1, 0, 2, 0, 2, 0, 1, 0, 3, 0]);
    assert!(stream([0xf0, 0x35]).unwrap_err().contains("there was not"));
    assert!(stream([0x00, 0xf0]).unwrap_err().contains("there was not"));
}

#[test]
fn filters_give_back_what_they_were_made_of() {
    use filters::Filter;
    // YCoCg of 6 bits and back, every third colour.
    for [r, g, b] in (0..64)
        .step_by(3)
        .flat_map(|r| (0..64).step_by(7).map(move |g| [r, g, 63 - r]))
    {
        let co = (r - b) >> 1;
        let half = b + co;
        let cg = (g - half) >> 1;
        let y = half + cg;
        let mut bytes = [y as u8, co as u8, cg as u8, 0b11_1111];
        Filter::Color.decode(&mut bytes, 4);
        // A bit of each difference is lost.
        for (got, c) in bytes.into_iter().zip([r, g, b]) {
            assert!(
                (f64::from(got) / 255.0 - f64::from(c) / 63.0).abs() < 0.025,
                "{bytes:?}"
            );
        }
        assert_eq!(bytes[3], 255);
    }
    let mut bytes = 1.5_f32.to_bits().to_le_bytes();
    bytes.copy_from_slice(&(-1_i32 << 24 | 3).to_le_bytes());
    Filter::Exponential.decode(&mut bytes, 4);
    assert_eq!(f32::from_le_bytes(bytes), 1.5);
    // Straight down on an octahedron of 8 bits is a corner of its square.
    let mut down = [127, 127, 127, 9];
    Filter::Octahedral.decode(&mut down, 4);
    assert_eq!(down, [0, 0, 129, 9]);
    // A turn of none: the largest component is the last.
    let mut none: [u8; 8] = [0, 0, 0, 0, 0, 0, 0xff, 0x7f];
    Filter::Quaternion.decode(&mut none, 8);
    assert_eq!(none, [0, 0, 0, 0, 0, 0, 0xff, 0x7f]);
}
