//! The map file as a map builder of the framework.

use rumbo_core::map::{Grid, Layer, Lines, Map};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, MapBuilder, MapError, MapInput};

use super::{StaticMapParams, load_static};

rumbo_core::register_map_builder!(
    StaticMapParams,
    "static_map",
    "a map from a file, unchanged by what is seen"
);

/// Layers from a file.
#[derive(Debug)]
pub struct StaticMap {
    grid: Grid,
    lines: Option<Lines>,
}

impl Plugin<dyn MapBuilder> for StaticMapParams {
    fn manifest(&self) -> Manifest {
        Manifest { gives_layers: vec![Layer::Grid, Layer::Lines], ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn MapBuilder>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let file = self.file.as_ref().map(|file| context.resolve(file)).or_else(|| context.world_map.clone());
        let Some(file) = file else {
            return Err(BuildError::at("file", "missing, and the world has no map of its own")
                .help("name a map_server YAML file or a TOML world file"));
        };
        let with_lines = context.wanted_layers.contains(&Layer::Lines);
        let (grid, lines) =
            load_static(&file, self, with_lines).map_err(|message| BuildError::at("file", message))?;
        Ok(Box::new(StaticMap { grid, lines: lines.map(|lines| Lines { lines: lines.into() }) }))
    }
}

impl MapBuilder for StaticMap {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        map.grid = Some(self.grid.clone());
        if let Some(lines) = &self.lines {
            map.lines = Some(lines.clone());
        }
        map.touch();
        Ok(())
    }

    fn insert(&mut self, _: &mut Cx<'_>, _: &MapInput<'_>, _: &mut Map) -> Result<(), MapError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
