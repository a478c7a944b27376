//! Pictures that another encoder wrote (zlib streams put together by hand), pictures that come back, and damaged ones.

use std::path::PathBuf;

use super::*;

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/depth_file").join(name)
}

fn scratch(test: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rumbo-depth-file-{}-{test}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn fault(path: &std::path::Path, encoding: DepthEncoding) -> String {
    read_depth(path, encoding).unwrap_err().to_string()
}

#[test]
fn pictures_of_another_encoder_are_read_to_the_count() {
    let gray = read_depth(&data("gray16_3x2.png"), DepthEncoding::Gray16).unwrap();
    let counts = vec![0, 1, 255, 256, 5000, 65_535];
    assert_eq!(gray, DepthPicture { width: 3, height: 2, counts });
    let pair = read_depth(&data("two_channel_4x2.png"), DepthEncoding::TwoChannel).unwrap();
    assert_eq!((pair.width, pair.height), (4, 2));
    // The published decoding table has red, green and what they mean together, in the order of the picture.
    let table = std::fs::read_to_string(data("dc_depth_decode.csv")).unwrap();
    let raw = table.lines().skip(1).map(|line| line.split(',').nth(2).unwrap().parse().unwrap());
    assert_eq!(pair.counts, raw.collect::<Vec<u16>>());
}

#[test]
fn a_pgm_is_read_high_byte_first_and_may_have_comments() {
    let path = scratch("pgm").join("a.pgm");
    std::fs::write(&path, b"P5 # a comment\n3 1\n8191\n\x00\x01\x10\x00\x1f\xff").unwrap();
    let read = read_depth(&path, DepthEncoding::Gray16).unwrap();
    assert_eq!(read, DepthPicture { width: 3, height: 1, counts: vec![1, 4096, 8191] });
    assert!(fault(&path, DepthEncoding::TwoChannel).contains("is a PGM, which has one channel"));
    std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
}

#[test]
fn what_is_written_comes_back() {
    let folder = scratch("back");
    // Every count of 13 bits, and all bits of the second half beyond them.
    let low: Vec<u16> = (0..8192).collect();
    let high = low.iter().map(|count| count << 3 | count >> 10).collect();
    for (name, encoding, counts) in [
        ("a.png", DepthEncoding::Gray16, &high),
        ("a.pgm", DepthEncoding::Gray16, &high),
        ("b.png", DepthEncoding::TwoChannel, &low),
    ] {
        let picture = DepthPicture { width: 128, height: 64, counts: counts.clone() };
        let path = folder.join(name);
        write_depth(&path, encoding, &picture).unwrap();
        assert_eq!(read_depth(&path, encoding).unwrap(), picture, "{name}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_would_not_come_back_is_not_written() {
    let folder = scratch("not-written");
    let picture = |counts: Vec<u16>| DepthPicture { width: 2, height: 1, counts };
    let refused = |name: &str, encoding, picture: &DepthPicture| {
        let path = folder.join(name);
        let error = write_depth(&path, encoding, picture).unwrap_err().to_string();
        assert!(!path.exists(), "{error}");
        error
    };
    let few = refused("a.png", DepthEncoding::Gray16, &picture(vec![1]));
    assert!(few.contains("2 x 1 pixels, but 1 counts"), "{few}");
    let large = refused("a.png", DepthEncoding::TwoChannel, &picture(vec![1, 8192]));
    assert!(large.contains("a count is 8192, two channels hold at most 8191"), "{large}");
    let pgm = refused("a.pgm", DepthEncoding::TwoChannel, &picture(vec![1, 2]));
    assert!(pgm.contains("one channel only"), "{pgm}");
    let empty = refused("a.png", DepthEncoding::Gray16, &DepthPicture::default());
    assert!(empty.contains("0 x 0 pixels"), "{empty}");
    let missing = folder.join("no/a.png");
    let error = write_depth(&missing, DepthEncoding::Gray16, &picture(vec![1, 2])).unwrap_err();
    assert!(matches!(error, DepthFileError::Unwritable { .. }), "{error}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn pictures_of_another_kind_are_named() {
    for (name, encoding, expected) in [
        ("gray8_3x2.png", DepthEncoding::Gray16, "one channel of 8 bits, expected one channel of 16 bits"),
        ("two_channel_4x2.png", DepthEncoding::Gray16, "3 channels of 8 bits, expected one channel of 16"),
        ("gray16_3x2.png", DepthEncoding::TwoChannel, "one channel of 16 bits, expected red and green"),
        ("two_channel_bad_1x2.png", DepthEncoding::TwoChannel, "column 0, row 1: the red channel is 32, exp"),
        (
            "dc_depth_decode.csv",
            DepthEncoding::Gray16,
            "begins with \"red,\", expected a PNG or a binary PGM",
        ),
        ("huge_header.png", DepthEncoding::Gray16, "is 100000 x 100000 pixels, expected"),
        ("missing.png", DepthEncoding::Gray16, "cannot read the depth picture"),
        (".", DepthEncoding::Gray16, "this is not a file"),
    ] {
        let said = fault(&data(name), encoding);
        assert!(said.contains(expected), "{name}: {said}");
    }
}

#[test]
fn damaged_pictures_are_refused_with_their_fault() {
    let folder = scratch("damage");
    let refused = |name: &str, bytes: &[u8], expected: &str| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        let said = fault(&path, DepthEncoding::Gray16);
        assert!(said.contains(expected) && said.contains(name), "{said}");
    };
    refused("empty.png", b"", "the file is empty");
    refused("short.pgm", b"P5\n2 2\n65535\n\x00\x01\x00\x02\x00", "ends after 2 of 4 pixels");
    refused("narrow.pgm", b"P5\n2 2\n255\n\x00\x01\x00\x02", "largest value is 255, expected 256");
    refused("wide.pgm", b"P5\n2 2\n65536\n", "largest value is more than 65535");
    refused("over.pgm", b"P5\n2 1\n300\n\x01\x2c\x01\x2d", "column 1, row 0: the count is 301");
    refused("zero.pgm", b"P5\n0 2\n65535\n", "is 0 x 2 pixels");
    refused("huge.pgm", b"P5\n4294967295 4294967295\n65535\n", "4294967295 x 4294967295 pixels");
    refused("words.pgm", b"P5\ntwo 2\n65535\n", "the width of the PGM header is \"two\"");
    refused("header.pgm", b"P5\n2", "the PGM header ends before its height");
    let whole = std::fs::read(data("gray16_3x2.png")).unwrap();
    for n_bytes in 9..whole.len() - 12 {
        // The last chunk only says that the picture is over; without it every pixel is there.
        refused("cut.png", &whole[..n_bytes], "broken picture");
    }
    for idx in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[idx] ^= 0x40;
        std::fs::write(folder.join("flipped.png"), &bytes).unwrap();
        // A flipped bit is refused, or changes no pixel.
        if let Ok(picture) = read_depth(&folder.join("flipped.png"), DepthEncoding::Gray16) {
            assert_eq!(picture.counts, [0, 1, 255, 256, 5000, 65_535], "byte {idx}");
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
