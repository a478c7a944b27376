//! Walls, boxes, ramps, steps, doors, people and marks that a pipeline adds to a world, with the keys that they have in a world file.

use serde::{Deserialize, Serialize};

use super::{WorldFault, WorldScene, parse};

/// Things for a world, as they are written: `{ box = [{ center = [2.0, 1.0], size = [0.5, 0.5] }] }`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Things(toml::Table);

impl Things {
    /// What they are; on no map, whatever they say.
    ///
    /// # Errors
    /// Every fault, with the key that it is in.
    pub fn read(&self) -> Result<WorldScene, Vec<WorldFault>> {
        let (mut scene, faults) = parse::things(&self.0.to_string());
        if !faults.is_empty() {
            return Err(faults);
        }
        scene.walls.iter_mut().for_each(|wall| wall.mapped = false);
        scene.boxes.iter_mut().for_each(|solid| solid.mapped = false);
        Ok(scene)
    }
}

impl WorldScene {
    /// Puts other things into this world.
    pub fn add(&mut self, other: WorldScene) {
        self.walls.extend(other.walls);
        self.boxes.extend(other.boxes);
        self.ramps.extend(other.ramps);
        self.persons.extend(other.persons);
        self.doors.extend(other.doors);
        self.marks.extend(other.marks);
    }

    /// Takes away the box, ramp, step, door or person with this name. Returns whether there was one.
    pub fn remove(&mut self, name: &str) -> bool {
        let n_things = |scene: &WorldScene| {
            scene.boxes.len() + scene.ramps.len() + scene.doors.len() + scene.persons.len()
        };
        let n_before = n_things(self);
        self.boxes.retain(|solid| solid.name != name);
        self.ramps.retain(|ramp| ramp.name != name);
        self.doors.retain(|door| door.name != name);
        self.persons.retain(|person| person.name != name);
        n_things(self) < n_before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_have_the_keys_of_a_world_file_and_are_on_no_map() {
        let things = |text: &str| Things(toml::from_str(text).unwrap());
        let text = "box = [{ name = \"crate\", center = [2, 1], size = [0.5, 0.5], mapped = true }]\n\
                    person = [{ route = [[1.0, 1.0]] }]\ndoor = [{ from = [0, 0], to = [1, 0], material = \"glass\" }]";
        let scene = things(text).read().unwrap();
        assert_eq!((scene.boxes.len(), scene.persons.len(), scene.doors.len()), (1, 1, 1));
        assert!(!scene.boxes[0].mapped);
        let mut world = WorldScene::default();
        world.add(scene);
        assert!(world.remove("crate") && world.boxes.is_empty() && !world.remove("crate"));

        let faults = things("box = [{ center = [2, 1], size = [0.5] }]\nbounds = 3").read().unwrap_err();
        let keys: Vec<&str> = faults.iter().map(|fault| fault.key.as_str()).collect();
        assert_eq!(keys, ["box[0].size", "bounds"]);
        let raised = "ramp = [{ name = \"way up\", center = [2, 1], size = [2, 1], z_to_m = 0.5 }]\n\
                      step = [{ center = [4, 1], size = [2, 1], height_m = 0.5 }]";
        world.add(things(raised).read().unwrap());
        assert!(world.ramps.len() == 2 && world.remove("way up") && world.remove("step"));

        assert_eq!(Things::default().read(), Ok(WorldScene::default()));
    }
}
