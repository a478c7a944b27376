mod round_trip;

use std::path::PathBuf;

use super::*;

/// A folder of its own for each test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("rumbo-map-file-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    fn yaml(&self, keys: &str) -> PathBuf {
        self.file("map.yaml", keys)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const HEADER: &str = "image: map.pgm\nresolution: 0.05\norigin: [1.0, -2.0, 0.5]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

fn load_picture(folder: &Folder, picture: impl AsRef<[u8]>) -> Result<MapImage, MapFileError> {
    folder.file("map.pgm", picture);
    load_map(&folder.yaml(HEADER), DEFAULT_MAX_CELLS)
}

#[test]
fn the_bottom_line_of_the_picture_is_row_zero() {
    let folder = Folder::new("rows");
    let map = load_picture(&folder, b"P2 # a comment\n# another\n3 2\n255\n0 254 205\n254 254 0\n").unwrap();
    assert_eq!((map.width, map.height), (3, 2));
    assert_eq!(map.cells, [0, 0, 100, 100, 0, UNKNOWN]);
    assert_eq!(map.origin, [1.0, -2.0, 0.5]);
    assert!(map.is_occupied(2, 0) && !map.is_occupied(1, 1));
    assert_eq!(map.occupancy(3, 0), UNKNOWN);
}

#[test]
fn binary_and_text_pictures_of_8_and_16_bits_read_alike() {
    let folder = Folder::new("bits");
    let text = load_picture(&folder, "P2\n2 2\n255\n0 255 255 0\n").unwrap();
    let binary = load_picture(&folder, b"P5\n2 2\n255\n\x00\xff\xff\x00").unwrap();
    let wide = load_picture(&folder, b"P5\n2 2\n1000\n\x00\x00\x03\xe8\x03\xe8\x00\x00").unwrap();
    assert_eq!(text, binary);
    assert_eq!(text, wide);
}

#[test]
fn negate_scale_and_raw_follow_map_server() {
    let folder = Folder::new("modes");
    folder.file("map.pgm", b"P5\n5 1\n255\n\x00\x64\x80\xcd\xff");
    let load = |extra: &str| {
        let yaml = folder.yaml(&format!("image: map.pgm\nresolution: 1.0\norigin: [0, 0, 0]\n{extra}"));
        load_map(&yaml, DEFAULT_MAX_CELLS).unwrap().cells
    };
    assert_eq!(load(""), [100, UNKNOWN, UNKNOWN, UNKNOWN, 0]);
    assert_eq!(load("negate: 1\n"), [0, UNKNOWN, UNKNOWN, 100, 100]);
    assert_eq!(load("negate: true\n"), [0, UNKNOWN, UNKNOWN, 100, 100]);
    // p(100) = 0.6078: 1 + 98 (0.6078 - 0.196) / 0.454 = 89.9; p(128) = 0.498: 66.2; p(205) = 0.19608: 1.02.
    assert_eq!(load("mode: scale\n"), [100, 89, 66, 1, 0]);
    assert_eq!(load("mode: raw\n"), [0, 100, UNKNOWN, UNKNOWN, UNKNOWN]);
}

#[test]
fn a_png_reads_like_the_same_pgm_and_transparent_is_unknown() {
    let folder = Folder::new("png");
    let yaml = folder.yaml("image: map.png\nresolution: 0.1\norigin: [0, 0, 0]\n");
    let gray = image::GrayImage::from_raw(2, 2, vec![0, 254, 205, 254]).unwrap();
    gray.save(folder.0.join("map.png")).unwrap();
    assert_eq!(load_map(&yaml, DEFAULT_MAX_CELLS).unwrap().cells, [UNKNOWN, 0, 100, 0]);
    let alpha = image::RgbaImage::from_raw(2, 1, vec![0, 0, 0, 255, 0, 0, 0, 0]).unwrap();
    alpha.save(folder.0.join("map.png")).unwrap();
    assert_eq!(load_map(&yaml, DEFAULT_MAX_CELLS).unwrap().cells, [100, UNKNOWN]);
}

#[test]
fn a_saved_map_loads_back_to_the_same_cells() {
    let folder = Folder::new("save");
    let yaml = folder.0.join("saved.yaml");
    let map = MapImage {
        width: 3,
        height: 2,
        resolution_m: 0.025,
        origin: [-0.1, 3.0, 0.7],
        cells: vec![0, 100, -1, -1, 0, 100],
    };
    for format in [PictureFormat::Pgm, PictureFormat::Png] {
        save_map(&yaml, &map, SavedAs::Trinary, format).unwrap();
        assert_eq!(load_map(&yaml, DEFAULT_MAX_CELLS).unwrap(), map);
    }
    let percents = MapImage { cells: vec![0, 1, 50, 99, 100, -1], ..map };
    save_map(&yaml, &percents, SavedAs::Raw, PictureFormat::Pgm).unwrap();
    assert_eq!(load_map(&yaml, DEFAULT_MAX_CELLS).unwrap(), percents);
    let short = MapImage { cells: vec![0], ..percents };
    assert!(matches!(
        save_map(&yaml, &short, SavedAs::Raw, PictureFormat::Pgm),
        Err(MapFileError::Inconsistent { .. })
    ));
}

#[test]
fn a_single_cell_is_a_map() {
    assert_eq!(load_picture(&Folder::new("single"), b"P5 1 1 255\n\x00").unwrap().cells, [100]);
}

#[test]
fn a_huge_header_is_refused_before_its_cells_are_allocated() {
    let folder = Folder::new("huge");
    let message = load_picture(&folder, "P5\n20000 20000\n255\n").unwrap_err().to_string();
    assert!(message.ends_with(
        "map.pgm: the picture is 20000 x 20000 = 400000000 cells, more than max_cells = 64000000; \
         crop or scale the map, or raise max_cells"
    ));
    let overflow = load_picture(&folder, format!("P5\n{0} {0}\n255\n", u64::MAX)).unwrap_err();
    assert!(matches!(overflow, MapFileError::TooLarge { width: u64::MAX, .. }));
    // The header chunk of a PNG of 20,000 x 20,000 gray cells with no data behind it.
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x4e\x20\0\0\x4e\x20\x08\0\0\0\0".to_vec();
    png.extend(png_crc(&png[12..29]).to_be_bytes());
    png.extend(b"\0\0\0\0IDAT\x35\xaf\x06\x1e");
    let error = load_picture(&folder, &png).unwrap_err();
    assert!(matches!(error, MapFileError::TooLarge { width: 20_000, .. }), "{error}");
}

fn png_crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
    })
}

#[test]
fn broken_pictures_say_what_is_broken() {
    let folder = Folder::new("broken");
    for (picture, expected) in [
        ("P5\n0 0\n255\n", "the picture is 0 x 0 cells, expected at least 1 x 1"),
        ("P5\n4 4\n255\nabc", "the picture ends after 3 of 16 cells; the file is truncated"),
        ("P2\n2 2\n255\n1 2 3", "the picture ends after 3 of 4 cells; the file is truncated"),
        ("P2\n2 1\n255\n1 x", "value 1 of the picture is \"x\""),
        ("P6\n1 1\n255\nabc", "the picture begins with \"P6\\n1\", expected a gray PGM (P2 or P5) or a PNG"),
        ("", "the picture begins with \"\", expected a gray PGM"),
        ("P5\n4", "the PGM header ends before its height"),
        ("P5\nfour 4", "the width of the PGM header is \"four\", expected a number"),
        ("P5\n-4 4", "the width of the PGM header is \"-4\", expected a number"),
        ("P5\n1 1\n70000\na", "the largest value of the PGM header is 70000"),
        ("\u{89}", "expected a gray PGM"),
    ] {
        let message = load_picture(&folder, picture).unwrap_err().to_string();
        assert!(message.contains(expected), "{picture:?} gave {message}");
    }
    let truncated_png = load_picture(&folder, b"\x89PNG\r\n\x1a\n\0\0").unwrap_err();
    assert!(matches!(truncated_png, MapFileError::ImageBroken { .. }), "{truncated_png}");
}

#[test]
fn broken_headers_name_the_key() {
    let folder = Folder::new("headers");
    folder.file("map.pgm", "P2 1 1 255 0");
    let image = "image: map.pgm\n";
    for (keys, expected) in [
        (
            format!("{image}resolution: .nan\norigin: [0, 0, 0]\n"),
            "resolution is NaN, expected meters per cell",
        ),
        (format!("{image}resolution: 0.0\norigin: [0, 0, 0]\n"), "resolution is 0"),
        (format!("{image}resolution: -0.05\norigin: [0, 0, 0]\n"), "resolution is -0.05"),
        (format!("{image}resolution: 1\norigin: [0, 0]\n"), "origin is a list of 2 numbers, expected three"),
        (format!("{image}resolution: 1\norigin: [0, .inf, 0]\n"), "origin is [0.0, inf, 0.0]"),
        (format!("{image}resolution: 1\norigin: [0, 0, 0]\nnegate: 2\n"), "negate is 2, expected 0 or 1"),
        (format!("{image}resolution: 1\norigin: [0, 0, 0]\noccupied_thresh: 65\n"), "occupied_thresh is 65"),
        (format!("{image}resolution: 1\norigin: [0, 0, 0]\nfree_thresh: 0.9\n"), "free_thresh is 0.9"),
        (format!("{image}resolution: 1\norigin: [0, 0, 0]\nmode: gray\n"), "gray"),
        (format!("{image}origin: [0, 0, 0]\n"), "resolution"),
        ("image: \"\"\nresolution: 1\norigin: [0, 0, 0]\n".to_string(), "image is empty"),
        ("- not\n- a map\n".to_string(), "not a map_server YAML file"),
        ("image: [\n".to_string(), "not a map_server YAML file"),
        (String::new(), "not a map_server YAML file"),
    ] {
        let message = load_map(&folder.yaml(&keys), DEFAULT_MAX_CELLS).unwrap_err().to_string();
        assert!(message.contains(expected), "{keys:?} gave {message}");
    }
}

#[test]
fn missing_files_are_told_apart() {
    let folder = Folder::new("missing");
    let no_yaml = load_map(&folder.0.join("absent.yaml"), DEFAULT_MAX_CELLS).unwrap_err();
    assert!(matches!(no_yaml, MapFileError::Unreadable { .. }));
    let no_picture = load_map(&folder.yaml(HEADER), DEFAULT_MAX_CELLS).unwrap_err();
    assert!(matches!(no_picture, MapFileError::ImageUnreadable { .. }));
}

#[test]
fn a_grid_is_saved_where_it_lies_and_comes_back() {
    use rumbo_core::map::{Grid, GridHeader};
    let mut header = *Grid::unknown(6, 5, 0.25).unwrap().header();
    header = GridHeader { origin: [2.0, -3.0, 0.0], occupied_above: 0.0, free_below: 0.0, ..header };
    let mut cells = vec![0.0f32; 30];
    cells[2 * 6 + 1] = -0.4;
    cells[3 * 6 + 3] = 2.2;
    let grid = Grid::new(header, cells.into()).unwrap();
    let folder = std::env::temp_dir().join(format!("rumbo-of-grid-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for (saved_as, values) in [(SavedAs::Trinary, [0, 100]), (SavedAs::Raw, [40, 90])] {
        let image = MapImage::of_grid(&grid, saved_as).unwrap();
        assert_eq!((image.width, image.height), (3, 2));
        assert_eq!(image.origin, [2.25, -2.5, 0.0]);
        assert_eq!(image.cells, [values[0], UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, values[1]]);
        for format in [PictureFormat::Pgm, PictureFormat::Png] {
            save_map(&folder.join("map.yaml"), &image, saved_as, format).unwrap();
            assert_eq!(load_map(&folder.join("map.yaml"), 100).unwrap(), image);
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(MapImage::of_grid(&Grid::unknown(3, 3, 0.1).unwrap(), SavedAs::Raw), None);
}
