//! What is written reads back to the same cells: every mode, both formats, both senses of black.

use super::*;

const FORMATS: [PictureFormat; 2] = [PictureFormat::Pgm, PictureFormat::Png];

fn row(cells: Vec<i8>) -> MapImage {
    MapImage { width: cells.len(), height: 1, resolution_m: 0.025, origin: [-0.1, 3.0, 0.7], cells }
}

fn every_percent() -> Vec<i8> {
    (0..=100).collect()
}

/// Writes, reads, and compares both header and cells.
fn assert_comes_back(folder: &Folder, map: &MapImage, reading: &ShadeReading, format: PictureFormat) {
    let yaml = folder.0.join("map.yaml");
    save_map_to_be_read(&yaml, map, reading, format).unwrap_or_else(|error| panic!("{reading:?}: {error}"));
    assert_eq!(&load_map(&yaml, DEFAULT_MAX_CELLS).unwrap(), map, "{reading:?} {format:?}");
    let header = load_map_header(&yaml).unwrap();
    assert_eq!(header.reading(), *reading);
    assert_eq!((header.resolution_m, header.origin), (map.resolution_m, map.origin));
}

#[test]
fn three_classes_come_back_in_every_mode_format_sense_and_threshold() {
    let folder = Folder::new("three-classes");
    let (known, all) = (row(vec![0, 100, 0]), row(vec![UNKNOWN, 0, 100, UNKNOWN]));
    for mode in [MapMode::Trinary, MapMode::Scale, MapMode::Raw] {
        for negate in [false, true] {
            for (free_thresh, occupied_thresh) in
                [(0.196, 0.65), (0.25, 0.65), (0.1, 0.65), (0.45, 0.5), (0.01, 0.99)]
            {
                let reading = ShadeReading { mode, negate, occupied_thresh, free_thresh };
                for format in FORMATS {
                    assert_comes_back(&folder, &known, &reading, format);
                    // Unknown in mode scale is transparent, which PGM cannot be.
                    if mode != MapMode::Scale || format == PictureFormat::Png {
                        assert_comes_back(&folder, &all, &reading, format);
                    }
                }
            }
        }
    }
}

#[test]
fn every_percent_comes_back_in_scale_and_raw() {
    let folder = Folder::new("percents");
    for format in FORMATS {
        for saved_as in [SavedAs::Scale, SavedAs::Raw] {
            let yaml = folder.0.join("map.yaml");
            let mut cells = every_percent();
            if (saved_as, format) != (SavedAs::Scale, PictureFormat::Pgm) {
                cells.push(UNKNOWN);
            }
            let map = row(cells);
            save_map(&yaml, &map, saved_as, format).unwrap();
            assert_eq!(load_map(&yaml, DEFAULT_MAX_CELLS).unwrap(), map, "{saved_as:?} {format:?}");
        }
    }
}

#[test]
fn trinary_keeps_the_class_and_nothing_else() {
    let folder = Folder::new("classes");
    let yaml = folder.0.join("map.yaml");
    for format in FORMATS {
        save_map(&yaml, &row(vec![0, 19, 20, 65, 66, 100, UNKNOWN]), SavedAs::Trinary, format).unwrap();
        let back = load_map(&yaml, DEFAULT_MAX_CELLS).unwrap();
        assert_eq!(back.cells, [0, 0, UNKNOWN, UNKNOWN, 100, 100, UNKNOWN]);
    }
}

#[test]
fn what_a_mode_cannot_say_is_refused_and_nothing_is_written() {
    let folder = Folder::new("unsayable");
    let yaml = folder.0.join("map.yaml");
    let unknown =
        save_map(&yaml, &row(vec![0, UNKNOWN, -7]), SavedAs::Scale, PictureFormat::Pgm).unwrap_err();
    let message = unknown.to_string();
    assert!(
        message.contains("in mode scale no shade of this picture is read as unknown, the value of 2 cells"),
        "{message}"
    );
    let gray = save_map_to_be_read(
        &yaml,
        &row(vec![42]),
        &ShadeReading::usual(MapMode::Trinary),
        PictureFormat::Png,
    );
    assert!(gray.unwrap_err().to_string().contains("read as 42 percent, the value of 1 cells"));
    // With the usual thresholds no gray is exactly at 65 percent, so that 99 cannot be said.
    let scale = ShadeReading::usual(MapMode::Scale);
    let refused = save_map_to_be_read(&yaml, &row(every_percent()), &scale, PictureFormat::Pgm).unwrap_err();
    assert!(matches!(refused, MapFileError::Unsayable { occupancy: 99, n_cells: 1, .. }), "{refused}");
    assert!(!yaml.exists());
}

#[test]
fn trinary_files_have_the_grays_of_map_saver() {
    let folder = Folder::new("grays");
    save_map(&folder.0.join("map.yaml"), &row(vec![0, 100, UNKNOWN]), SavedAs::Trinary, PictureFormat::Pgm)
        .unwrap();
    assert_eq!(std::fs::read(folder.0.join("map.pgm")).unwrap(), b"P5\n3 1\n255\n\xfe\x00\xcd");
    let header = std::fs::read_to_string(folder.0.join("map.yaml")).unwrap();
    let expected = "image: map.pgm\nmode: trinary\nresolution: 0.025\norigin: [-0.1, 3.0, 0.7]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    assert_eq!(header, expected);
}
