//! Regions that came too near.

use super::*;

const RULE: NearRule = NearRule { near_m: 0.75, least_m: 0.2, closing_m_s: 1.0, unit_m: 0.001 };

/// A camera of 64 x 48 at 0.3 m; what is between 0.05 and 0.6 m counts.
fn fill(memory: &mut NearMemory, elapsed_s: f64, counts: &[u16]) -> Vec<u16> {
    let band = HeightBand::of_pitch(0.3, 0.0, [0.05, 0.6]);
    let mut filled = counts.to_vec();
    let n = memory.fill(&camera(64, 48), &band, &RULE, elapsed_s, &mut filled).unwrap();
    assert_eq!(n, filled.iter().zip(counts).filter(|(now, before)| now != before).count());
    filled
}

#[test]
fn a_wall_that_comes_too_near_stays_as_near_as_it_can_have_come() {
    let mut memory = NearMemory::default();
    assert_eq!(fill(&mut memory, 0.1, &[600; 3072]), [600; 3072]);
    assert_eq!(fill(&mut memory, 0.1, &[0; 3072]), [500; 3072], "a tenth of a second at 1 m/s");
    assert_eq!(fill(&mut memory, 0.1, &[0; 3072]), [400; 3072]);
    assert_eq!(fill(&mut memory, 9.0, &[0; 3072]), [200; 3072], "never nearer than the near plane");
    assert_eq!(fill(&mut memory, 0.1, &[900; 3072]), [900; 3072], "seen again");
    assert_eq!(fill(&mut memory, 0.1, &[0; 3072]), [0; 3072], "it was not near");
}

#[test]
fn a_wall_that_was_not_near_and_a_floor_do_not_become_one() {
    let mut memory = NearMemory::default();
    fill(&mut memory, 0.1, &[760; 3072]);
    assert_eq!(fill(&mut memory, 0.1, &[0; 3072]), [0; 3072]);
    // 0.7 m ahead and below the band: a floor, or what is as low as one.
    let mut floor = [0; 3072];
    floor[44 * 64..].fill(700);
    assert!(0.3 + 0.7 * camera(64, 48).up()[44] < 0.05);
    fill(&mut memory, 0.1, &floor);
    assert_eq!(fill(&mut memory, 0.1, &[0; 3072]), [0; 3072]);
}

/// Turning from a wall to an empty hall: only the hall's floor can be seen, in the lower rows.
#[test]
fn a_floor_below_frees_what_is_above_it() {
    let mut memory = NearMemory::default();
    fill(&mut memory, 0.1, &[600; 3072]);
    let mut hall = [0; 3072];
    for row in hall.chunks_exact_mut(64).skip(40) {
        // The left half only.
        row[..32].fill(900);
    }
    let filled = fill(&mut memory, 0.1, &hall);
    for (pixel, count) in filled.iter().enumerate() {
        let expected = if pixel % 64 < 32 { hall[pixel] } else { 500 };
        assert_eq!(*count, expected, "pixel {pixel}");
    }
}

/// A region of 64 pixels with a few readings left is not seen; holes in one that is seen stay holes.
#[test]
fn chance_holes_are_not_filled() {
    let mut memory = NearMemory::default();
    let mut rng = rumbo_core::rng::stream(8, "holes");
    for _ in 0..20 {
        let counts: Vec<u16> = (0..3072).map(|_| if rng.random::<f64>() < 0.5 { 0 } else { 600 }).collect();
        assert_eq!(fill(&mut memory, 0.1, &counts), counts);
    }
}

#[test]
fn pictures_of_any_size_are_survived() {
    for (columns, rows) in [(1, 1), (7, 9), (17, 8)] {
        let (mut memory, rays) = (NearMemory::default(), camera(columns, rows));
        let band = HeightBand::of_pitch(0.3, 0.0, [-9.0, 9.0]);
        let mut counts = vec![500; rays.n_pixels()];
        assert_eq!(memory.fill(&rays, &band, &RULE, 0.1, &mut counts), Ok(0));
        counts.fill(0);
        assert_eq!(memory.fill(&rays, &band, &RULE, 0.1, &mut counts), Ok(rays.n_pixels()));
        assert!(memory.fill(&rays, &band, &RULE, 0.1, &mut [0; 2]).is_err());
    }
}
