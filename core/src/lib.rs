//! Messages, maps, stage traits, registry, pipeline file and engine of Rumbo.
