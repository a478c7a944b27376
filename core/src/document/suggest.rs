//! What somebody may have meant.

/// Endings that say a unit; the longest first, since `_m_s` ends in `_s`.
const UNITS: [&str; 40] = [
    "_rad_s2", "_deg_s2", "_mm_s2", "_cm_s2", "_m_s2", "_rad_s", "_deg_s", "_km_h", "_mm_s", "_cm_s", "_m_s",
    "_deg_m", "_rad_m", "_radians", "_degrees", "_seconds", "_meters", "_minutes", "_percent", "_mps",
    "_rpm", "_khz", "_rad", "_deg", "_min", "_sec", "_hz", "_mm", "_cm", "_km", "_in", "_ft", "_ms", "_us",
    "_ns", "_px", "_kg", "_m2", "_m", "_s",
];

/// The candidate that looks most like `wanted`, if any looks like it at all.
pub fn did_you_mean<'c>(wanted: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    let lower = wanted.to_lowercase();
    let allowed = (wanted.chars().count() / 3).max(1);
    let distance = |candidate: &str| strsim::osa_distance(&lower, &candidate.to_lowercase());
    let close = candidates.into_iter().map(|candidate| (distance(candidate), candidate));
    let best = close.min_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.cmp(b.1)))?;
    (best.0 <= allowed).then_some(best.1)
}

/// What to say about a key that nobody knows.
pub fn unknown_key_message<'c>(wanted: &str, known: impl IntoIterator<Item = &'c str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    let stem = without_unit(wanted);
    let same_stem = |key: &&&str| without_unit(key) == stem && without_unit(key) != **key;
    if let Some(key) = known.iter().find(same_stem) {
        return format!("unknown key, units are in the key: {key}");
    }
    if let Some(key) = did_you_mean(wanted, known.iter().copied()) {
        return format!("unknown key, did you mean {key}?");
    }
    if let Some(key) =
        known.iter().find(|key| strsim::osa_distance(without_unit(key), stem) <= stem.len() / 4)
    {
        return format!("unknown key, did you mean {key}?");
    }
    match known.as_slice() {
        [] => "unknown key, expected none here".to_owned(),
        keys if keys.len() <= 14 => format!("unknown key, expected one of {}", keys.join(", ")),
        keys => format!("unknown key, expected one of {}, ...", keys[..14].join(", ")),
    }
}

fn without_unit(key: &str) -> &str {
    UNITS.iter().find_map(|unit| key.strip_suffix(unit)).unwrap_or(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: [&str; 5] =
        ["preferred_clearance_m", "stop_distance_m", "max_speed_m_s", "weights", "rate_hz"];

    #[test]
    fn a_misspelled_key_is_recognized() {
        let said = unknown_key_message("prefered_clearance_m", KNOWN);
        assert_eq!(said, "unknown key, did you mean preferred_clearance_m?");
        assert_eq!(did_you_mean("A_Star", ["a_star", "dp"]), Some("a_star"));
        assert_eq!(did_you_mean("dq", ["a_star", "dp"]), Some("dp"));
        assert_eq!(did_you_mean("potential_field", ["a_star", "dp"]), None);
    }

    #[test]
    fn a_key_that_is_wrong_only_in_its_unit_is_told_so() {
        for wrong in ["stop_distance", "stop_distance_cm", "stop_distance_meters"] {
            assert_eq!(
                unknown_key_message(wrong, KNOWN),
                "unknown key, units are in the key: stop_distance_m"
            );
        }
        for wrong in ["max_speed", "max_speed_mps", "max_speed_km_h"] {
            assert_eq!(unknown_key_message(wrong, KNOWN), "unknown key, units are in the key: max_speed_m_s");
        }
        assert_eq!(unknown_key_message("rate", KNOWN), "unknown key, units are in the key: rate_hz");
    }

    #[test]
    fn a_key_that_resembles_nothing_gets_the_list() {
        let said = unknown_key_message("color", KNOWN);
        assert!(
            said.starts_with("unknown key, expected one of preferred_clearance_m, stop_distance_m"),
            "{said}"
        );
        assert_eq!(unknown_key_message("color", []), "unknown key, expected none here");
    }

    #[test]
    fn the_longest_unit_is_taken_off() {
        assert_eq!(without_unit("max_speed_m_s"), "max_speed");
        assert_eq!(without_unit("max_turn_accel_deg_s2"), "max_turn_accel");
        assert_eq!(without_unit("weights"), "weights");
    }
}
