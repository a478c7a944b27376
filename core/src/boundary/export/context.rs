//! What an instance is made from.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{BadView, layers_from, pose3_from, read, robot_from, string_from};
use super::call::flag_from;
use crate::messages::SensorId;
use crate::stages::{Background, BuildContext};
use crate::time::Span;
use std::path::PathBuf;

/// The context behind a view.
///
/// # Safety
/// `view` points to a view whose parts are alive.
pub(super) unsafe fn context_from(view: *const rumbo_context) -> Result<BuildContext, BadView> {
    // SAFETY: for all blocks below: as promised by the caller.
    let view = unsafe { read(view) }.ok_or_else(|| BadView("the context points nowhere".to_owned()))?;
    let path = |text: rumbo_str| {
        let text = unsafe { string_from(text) };
        (!text.is_empty()).then(|| PathBuf::from(text))
    };
    let background = match view.is_threaded {
        0 => Background::inline(Span(view.latency_ns)),
        _ => Background::threaded(),
    };
    Ok(BuildContext {
        name: unsafe { string_from(view.name) },
        sensor: SensorId(view.sensor),
        robot: unsafe { robot_from(view.robot, None)? },
        base_from_sensor: pose3_from(&view.base_from_sensor, "base_from_sensor")?,
        rate_hz: (!view.rate_hz.is_nan()).then_some(view.rate_hz),
        seed: view.seed,
        folder: path(view.folder).unwrap_or_default(),
        world_map: path(view.world_map),
        world_recording: path(view.world_recording),
        wanted_layers: layers_from(view.wanted_layers),
        dry_run: view.dry_run != 0,
        background: background.under(&unsafe { flag_from(view.abort) }),
    })
}
