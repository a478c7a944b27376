//! The file of marks as a map builder of the framework.

use rumbo_core::map::{Landmarks, Layer, Map};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, MapBuilder, MapError, MapInput};

use super::{KnownMarksParams, load_marks_at, load_world_marks};

rumbo_core::register_map_builder!(
    KnownMarksParams,
    "known_marks",
    "marks that a robot can recognize, from a file"
);

/// Landmarks from a file.
#[derive(Debug)]
pub struct KnownMarks {
    landmarks: Landmarks,
}

impl Plugin<dyn MapBuilder> for KnownMarksParams {
    fn manifest(&self) -> Manifest {
        Manifest { gives_layers: vec![Layer::Landmarks], ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn MapBuilder>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let loaded = match (&self.file, &context.world_map) {
            (Some(file), _) => load_marks_at(&context.resolve(file), self.least_deviation_m),
            (None, Some(world)) => load_world_marks(world, self.least_deviation_m),
            (None, None) => Err("missing, and the world has no map of its own".to_owned()),
        };
        let landmarks = loaded.map_err(|message| {
            let help = "name a TOML file with tables [[mark]], or an MRCLAM folder";
            BuildError::at("file", message).help(help)
        })?;
        Ok(Box::new(KnownMarks { landmarks }))
    }
}

impl MapBuilder for KnownMarks {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        map.landmarks = Some(self.landmarks.clone());
        map.touch();
        Ok(())
    }

    fn insert(&mut self, _: &mut Cx<'_>, _: &MapInput<'_>, _: &mut Map) -> Result<(), MapError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
