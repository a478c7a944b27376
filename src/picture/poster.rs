//! The whole picture of a run: title, map, scale and legend.

use super::map_view::{MapView, Sign};
use super::sketch::{Anchor, Role, Sketch};
use crate::record::RunRecord;

const EDGE: f64 = 24.0;
const TITLE: f64 = 24.0;
const LETTERS: f64 = 15.0;
/// Room for the title and the line below it.
const HEAD: f64 = 84.0;
/// Height of a line of the legend.
const LEGEND_LINE: f64 = 26.0;
/// Legend entries keep this much room.
const LEGEND_ENTRY: f64 = 215.0;

/// A picture of the run that explains itself.
pub fn poster(record: &RunRecord) -> Sketch {
    let view = MapView::new(record, 1000.0, 760.0);
    let pixels_per_m = view.pixels_per_m();
    let (map, signs) = view.draw();
    let width = (map.width + 2.0 * EDGE).max(680.0);
    let n_columns = ((width - 2.0 * EDGE) / LEGEND_ENTRY).floor().max(1.0) as usize;
    let n_lines = signs.len().div_ceil(n_columns);
    let below = HEAD + map.height;
    let height = below + 44.0 + n_lines as f64 * LEGEND_LINE + EDGE * 0.5;

    let mut sheet = Sketch::sheet(width, height);
    let left = (width - map.width) / 2.0;
    let (map_width, map_height) = (map.width, map.height);
    sheet.place(map, [left, HEAD]);
    let (right, low) = (left + map_width, HEAD + map_height);
    // What reaches over the edge of the map is covered by paper.
    sheet.rectangle(Role::Paper, [0.0, 0.0], [width, HEAD]);
    sheet.rectangle(Role::Paper, [0.0, low], [width, height]);
    sheet.rectangle(Role::Paper, [0.0, 0.0], [left, height]);
    sheet.rectangle(Role::Paper, [right, 0.0], [width, height]);
    sheet.rectangle(Role::Frame, [left, HEAD], [right, low]);
    sheet.heading([EDGE, EDGE + TITLE * 0.7], TITLE, shortened(&record.name, width, TITLE));
    let line = shortened(&record.headline(), width, LETTERS);
    sheet.text(Role::Note, [EDGE, EDGE + TITLE + 20.0], LETTERS, Anchor::Start, line);
    scale_bar(&mut sheet, [EDGE, below + 26.0], pixels_per_m);
    for (idx, sign) in signs.iter().enumerate() {
        let (column, line) = (idx % n_columns, idx / n_columns);
        let x = EDGE + column as f64 * LEGEND_ENTRY;
        legend_entry(&mut sheet, [x, below + 62.0 + line as f64 * LEGEND_LINE], sign);
    }
    sheet
}

/// A text that fits; letters are taken as 0.6 of their height wide.
fn shortened(text: &str, width: f64, size: f64) -> String {
    let most = ((width - 2.0 * EDGE) / (size * 0.6)) as usize;
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

/// A round number of meters as a bar of fitting length.
pub fn scale_bar(sheet: &mut Sketch, [x, y]: [f64; 2], pixels_per_m: f64) {
    let lengths = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];
    let length_m = lengths.into_iter().rev().find(|m| m * pixels_per_m <= 160.0).unwrap_or(lengths[0]);
    let end = x + length_m * pixels_per_m;
    sheet.chain(Role::Frame, vec![[x, y - 8.0], [x, y], [end, y], [end, y - 8.0]]);
    sheet.text(Role::Note, [end + 8.0, y], LETTERS, Anchor::Start, format!("{length_m} m"));
}

fn legend_entry(sheet: &mut Sketch, [x, y]: [f64; 2], sign: &Sign) {
    let middle = [x + 14.0, y - 5.0];
    match sign.role {
        Role::Start | Role::End | Role::Ellipse | Role::Seen => sheet.circle(sign.role, middle, 7.0),
        Role::Obstacle | Role::Mark => sheet.circle(sign.role, middle, 4.0),
        Role::Goal => {
            sheet.circle(sign.role, middle, 7.0);
            for rise in [5.0, -5.0] {
                let ends = [[middle[0] - 5.0, middle[1] - rise], [middle[0] + 5.0, middle[1] + rise]];
                sheet.chain(sign.role, ends.to_vec());
            }
        }
        _ => sheet.chain(sign.role, vec![[x, y - 5.0], [x + 28.0, y - 5.0]]),
    }
    sheet.text(Role::Text, [x + 36.0, y], LETTERS, Anchor::Start, sign.words);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{Raster, Shape};
    use crate::record::test_record;

    #[test]
    fn the_poster_names_the_run_and_explains_its_signs() {
        let record = test_record();
        let sheet = poster(&record);
        let words: Vec<&str> = sheet
            .shapes
            .iter()
            .filter_map(|shape| match shape {
                Shape::Text { text, .. } => Some(text.as_str()),
                _ => None,
            })
            .collect();
        assert!(words.contains(&record.name.as_str()) && words.contains(&"true way"), "{words:?}");
        let png = Raster::draw(&sheet, 1.0).unwrap().png().unwrap();
        let image = image::load_from_memory(&png).unwrap();
        assert_eq!((image.width(), image.height()), (sheet.width.ceil() as u32, sheet.height.ceil() as u32));
    }

    #[test]
    fn a_long_title_ends_in_dots_inside_the_picture() {
        let cut = shortened(&"é".repeat(500), 680.0, TITLE);
        assert!(cut.ends_with('…') && cut.chars().count() < 50);
    }
}
