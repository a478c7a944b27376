//! Offices of any size, all of whose rooms differ.

use super::Office;
use rand::RngExt;
use rumbo_core::rng::stream;
use rumbo_kit::generated_world::GeneratedWorld;

/// One more piece of furniture for so many cells: ten square meters.
const CELLS_A_PIECE: usize = 4000;
/// Its edges, cells.
const PIECE_EDGE: std::ops::Range<usize> = 4..17;

impl Office {
    /// A square of `n` x `n` cells with rooms of 4 to 8 m, doors, boxes, and furniture at random places.
    pub fn generated(n: usize, seed: u64) -> Office {
        let GeneratedWorld { size, mut occupied } = GeneratedWorld::indoor(n, seed);
        let mut rng = stream(seed, "furniture");
        for _ in 0..n * n / CELLS_A_PIECE {
            let [wide, high] = [0; 2].map(|_| rng.random_range(PIECE_EDGE));
            let [col, row] = [wide, high].map(|edge| rng.random_range(0..n - edge));
            for row in row..row + high {
                occupied[size.index(col, row)..][..wide].fill(1);
            }
        }
        Office::of(size, occupied, &[])
    }
}
