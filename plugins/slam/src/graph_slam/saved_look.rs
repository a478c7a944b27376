//! A search for a loop that is not over yet, as bytes.

use super::atlas::Atlas;
use super::loops::{Look, Recognized, frames_of};
use super::saved::{count, pose, put_count, put_pose, put_some, some};
use rumbo_core::seal::Reader;

pub(super) fn put_look(to: &mut Vec<u8>, look: &Look) {
    put_count(to, look.frame);
    put_count(to, usize::from(look.is_wide));
    put_count(to, look.places.len());
    for (place, way_m) in &look.places {
        put_count(to, *place);
        to.extend(way_m.to_le_bytes());
    }
    put_some(to, look.best.as_ref(), |to, best| {
        put_count(to, best.place);
        put_pose(to, &best.place_from_frame);
        to.extend(best.score.to_le_bytes());
    });
}

pub(super) fn look(from: &mut Reader<'_>, atlas: &Atlas) -> Option<Look> {
    let known = |frame: usize| (frame < atlas.frames.len()).then_some(frame);
    let (frame, is_wide, n_places) = (known(count(from)?)?, count(from)? != 0, count(from)?);
    let place = |from: &mut Reader<'_>| Some((known(count(from)?)?, from.f64()?));
    let places = (0..n_places).map(|_| place(from)).collect::<Option<Vec<_>>>()?;
    let best = some(from, |from| {
        let (place, place_from_frame, score) = (known(count(from)?)?, pose(from)?, from.f64()?);
        Some(Recognized { place, place_from_frame, score, frames: frames_of(atlas, place) })
    })?;
    Some(Look { frame, is_wide, places, best })
}
