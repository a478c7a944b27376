//! Against geometry that is known exactly: walls, rays and poses of a small building.

mod building;
mod drives;
mod hard_places;
mod pieces;
