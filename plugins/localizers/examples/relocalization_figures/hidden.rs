//! Things close to the robot that hide half of its view.

use super::relocalization_work::{Clutter, Course, Ending, Laser, Office, Said};
use rumbo_core::rng::stream;
use rumbo_localizers::landmark_relaxation::LandmarkRelaxationParams;

/// So many starts on each of the three office maps, and in buildings that the map does not show.
pub fn run(n_starts: u64) {
    let params = LandmarkRelaxationParams::default();
    for (name, elsewhere) in [("5x5", "10x10"), ("10x10", "5x5"), ("20x20", "10x10")] {
        let office = Office::named(name);
        let known = office.knowledge(&params);
        for (place, is_known) in [(&office, true), (&Office::named(elsewhere), false)] {
            for clutter in [Clutter::HalfHidden, Clutter::HalfWalled] {
                let course = |seed: u64| {
                    let mut rng = stream(seed, "hidden");
                    let pose = place.pose(&mut rng);
                    let boxes = clutter.around(&pose, &mut rng);
                    let laser = Laser::lms200();
                    Course { office: place, known: &known, laser, boxes, map_from_base: pose }
                        .run(&params, seed)
                };
                let endings: Vec<Ending> = (0..n_starts).map(course).collect();
                let building = if is_known { "" } else { ", another building" };
                tell(&format!("{name} {clutter:?}{building}"), &endings);
            }
        }
    }
}

fn tell(which: &str, endings: &[Ending]) {
    let count = |of: &dyn Fn(&Ending) -> bool| endings.iter().filter(|ending| of(ending)).count();
    println!(
        "{which}: of {} found after 0, 1, 2, 3 moves {:?}; wrong after {:?}; ambiguous {}, lost {}, of them {} without a way to go",
        endings.len(),
        [0, 1, 2, 3].map(|n| count(&|e| e.is_success() && e.n_moves == n)),
        [0, 1, 2, 3].map(|n| count(&|e| e.is_wrong() && e.n_moves == n)),
        count(&|e| e.last == Said::Ambiguous),
        count(&|e| e.last == Said::Lost),
        count(&|e| e.last == Said::Lost && e.n_moves == 0),
    );
    for (seed, ending) in endings.iter().enumerate().filter(|(_, ending)| ending.is_wrong()).take(5) {
        println!("       start {seed}: {ending:?}");
    }
}
