//! Against the published warehouse's field values, central differences, and Newton's stationary points.

mod field_values;
mod index;
mod stationary_points;
mod warehouse;
