//! Lines of one value in a grid of values: marching squares (Lorensen and Cline, 1987, in the plane).

use rumbo_core::frames::Point2;
use rumbo_kit::potential::charge_map::MapFrame;
use std::collections::BTreeMap;

/// A line between the middles of two cells side by side: the lower left one, and whether the other is above it.
type Link = (usize, bool);

/// All lines of a level, each as a chain of points where links between middles of cells are crossed.
pub(super) fn iso_lines(frame: &MapFrame, values: &[f32], level: f32) -> Vec<Vec<Point2>> {
    let mut beside: BTreeMap<Link, Vec<Link>> = BTreeMap::new();
    for row in 0..frame.size.height.saturating_sub(1) {
        for col in 0..frame.size.width.saturating_sub(1) {
            for [a, b] in pieces(frame, values, level, frame.size.index(col, row)) {
                beside.entry(a).or_default().push(b);
                beside.entry(b).or_default().push(a);
            }
        }
    }
    // Chains with ends first, then what is closed.
    let ends = beside.iter().filter(|(_, next)| next.len() == 1).map(|(link, _)| *link);
    let order: Vec<Link> = ends.chain(beside.keys().copied()).collect();
    let mut lines = Vec::new();
    for first in order {
        let mut chain = vec![crossing(frame, values, level, first)];
        let mut here = first;
        while let Some(next) = take(&mut beside, here) {
            chain.push(crossing(frame, values, level, next));
            here = next;
        }
        if chain.len() > 1 {
            lines.push(chain);
        }
    }
    lines
}

/// The next link of a chain; the piece between the two is gone afterwards.
fn take(beside: &mut BTreeMap<Link, Vec<Link>>, here: Link) -> Option<Link> {
    let next = beside.get_mut(&here)?.pop()?;
    if let Some(back) = beside.get_mut(&next)
        && let Some(place) = back.iter().position(|link| *link == here)
    {
        back.remove(place);
    }
    Some(next)
}

/// Pieces of the line between the middles of four cells.
fn pieces(frame: &MapFrame, values: &[f32], level: f32, cell: usize) -> Vec<[Link; 2]> {
    let width = frame.size.width;
    // Below, right, above, left.
    let links: [Link; 4] = [(cell, false), (cell + 1, true), (cell + width, false), (cell, true)];
    let is_above = [cell, cell + 1, cell + width + 1, cell + width].map(|place| values[place] > level);
    let is_crossed = |k: usize| is_above[k] != is_above[(k + 1) % 4];
    let crossed: Vec<usize> = (0..4).filter(|k| is_crossed(*k)).collect();
    match crossed.as_slice() {
        [a, b] => vec![[links[*a], links[*b]]],
        // A saddle: cut off the corners that are above the level.
        [_, _, _, _] if is_above[0] => vec![[links[3], links[0]], [links[1], links[2]]],
        [_, _, _, _] => vec![[links[0], links[1]], [links[2], links[3]]],
        _ => Vec::new(),
    }
}

fn crossing(frame: &MapFrame, values: &[f32], level: f32, (cell, is_up): Link) -> Point2 {
    let other = if is_up { cell + frame.size.width } else { cell + 1 };
    let (a, b) = (f64::from(values[cell]), f64::from(values[other]));
    let share = if b == a { 0.5 } else { ((f64::from(level) - a) / (b - a)).clamp(0.0, 1.0) };
    let from = frame.middle_of(cell);
    from + (frame.middle_of(other) - from) * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_kit::GridSize;

    fn frame(n: usize) -> MapFrame {
        MapFrame { size: GridSize::new(n, n), origin: Point2::new(-5.0, -5.0), cell_m: 10.0 / n as f64 }
    }

    #[test]
    fn levels_of_a_bowl_are_closed_circles() {
        let frame = frame(100);
        let values: Vec<f32> =
            (0..frame.size.n_cells()).map(|cell| frame.middle_of(cell).coords.norm() as f32).collect();
        for radius in [1.0, 3.0] {
            let lines = iso_lines(&frame, &values, radius);
            assert_eq!(lines.len(), 1);
            assert_eq!(lines[0].first(), lines[0].last());
            assert!(lines[0].len() > 30);
            for point in &lines[0] {
                assert!((point.coords.norm() - f64::from(radius)).abs() < 2e-3, "{point}");
            }
        }
        // Beyond the rim the circle is four arcs.
        assert_eq!(iso_lines(&frame, &values, 6.0).len(), 4);
        assert!(iso_lines(&frame, &values, 9.0).is_empty());
    }

    #[test]
    fn a_saddle_is_two_lines_and_a_single_cell_none() {
        let frame = frame(2);
        assert_eq!(iso_lines(&frame, &[1.0, 0.0, 0.0, 1.0], 0.5).len(), 2);
        assert_eq!(iso_lines(&frame, &[0.0, 1.0, 1.0, 0.0], 0.5).len(), 2);
        let one = MapFrame { size: GridSize::new(1, 1), ..frame };
        assert!(iso_lines(&one, &[1.0], 0.5).is_empty());
    }
}
