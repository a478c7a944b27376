//! What a picture is made of: shapes in picture coordinates (pixels, y down), each with a role that decides its looks.

use super::MapImage;

/// What a shape stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// Background of the whole picture.
    Paper,
    /// Frame and ticks.
    Frame,
    /// Fine lines behind a chart.
    Rule,
    /// Plain letters.
    Text,
    /// Less important letters.
    Note,
    /// Where the robot really was.
    Truth,
    /// Where it thought it was, as it knows at the end where it keeps that.
    Estimate,
    /// Where it thought it was at the time, where it knew better at the end.
    AtTheTime,
    /// How sure it was.
    Ellipse,
    /// The path that it followed last.
    Path,
    /// Paths that were given up.
    OldPath,
    /// Levels of a planner's potential.
    Level,
    /// What a planner drew of its way before it was done.
    Draft,
    /// Single places that a planner marked.
    Mark,
    /// Obstacles that the map does not show.
    Obstacle,
    /// The hull at the start.
    Start,
    /// The hull at the end.
    End,
    /// Where it had to go.
    Goal,
    /// What a sensor sees.
    Seen,
    /// A wall of the map.
    Wall,
    /// A curve of a chart.
    Curve,
    /// A second curve of a chart.
    SecondCurve,
    /// A limit in a chart.
    Limit,
    /// One of many values in a chart.
    Dot,
    /// The middle half of many values, or a bar.
    Box,
    /// A mean and its interval.
    Mean,
}

/// Colors as 0xRRGGBB with opacity; `None` where a shape has no outline or no filling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// Name in style sheets.
    pub class: &'static str,
    /// Outline on light and on dark paper.
    pub stroke: Option<(u32, u32)>,
    /// Width of the outline, pixels.
    pub width: f64,
    /// Lengths of dash and gap, pixels.
    pub dash: Option<(f64, f64)>,
    /// Filling on light and on dark paper, and its opacity.
    pub fill: Option<(u32, u32, f64)>,
}

impl Role {
    /// All of them.
    pub const ALL: [Role; 26] = [
        Role::Paper,
        Role::Frame,
        Role::Rule,
        Role::Text,
        Role::Note,
        Role::Truth,
        Role::Estimate,
        Role::AtTheTime,
        Role::Ellipse,
        Role::Path,
        Role::OldPath,
        Role::Level,
        Role::Draft,
        Role::Mark,
        Role::Obstacle,
        Role::Start,
        Role::End,
        Role::Goal,
        Role::Seen,
        Role::Wall,
        Role::Curve,
        Role::SecondCurve,
        Role::Limit,
        Role::Dot,
        Role::Box,
        Role::Mean,
    ];

    /// Its looks. The hues are those of Okabe and Ito (2008), which color-blind people can tell apart.
    pub fn style(self) -> Style {
        const BLUE: (u32, u32) = (0x0072b2, 0x56b4e9);
        const ORANGE: (u32, u32) = (0xd55e00, 0xff8c42);
        const GREEN: (u32, u32) = (0x00835f, 0x2fd3a0);
        const PURPLE: (u32, u32) = (0xa6427f, 0xe08fc0);
        const AMBER: (u32, u32) = (0xb87700, 0xf0b429);
        let line =
            |class, stroke, width| Style { class, stroke: Some(stroke), width, dash: None, fill: None };
        let filled = |class, (light, dark): (u32, u32), opacity| Style {
            class,
            stroke: None,
            width: 0.0,
            dash: None,
            fill: Some((light, dark, opacity)),
        };
        match self {
            Role::Paper => filled("paper", (0xffffff, 0x16181d), 1.0),
            Role::Frame => line("frame", (0x8a9099, 0x6b727c), 1.0),
            Role::Rule => line("rule", (0xe3e6ea, 0x2c3037), 1.0),
            Role::Text => filled("text", (0x1b1f24, 0xe7eaee), 1.0),
            Role::Note => filled("note", (0x59616b, 0xa2abb6), 1.0),
            Role::Truth => line("truth", BLUE, 3.2),
            Role::Estimate => line("estimate", ORANGE, 1.5),
            Role::AtTheTime => Style { dash: Some((1.5, 3.0)), ..line("at-the-time", ORANGE, 0.8) },
            Role::Ellipse => Style { width: 0.8, stroke: Some(ORANGE), ..filled("ellipse", ORANGE, 0.12) },
            Role::Path => Style { dash: Some((7.0, 4.0)), ..line("path", PURPLE, 1.8) },
            Role::OldPath => Style { dash: Some((2.0, 4.0)), ..line("old-path", PURPLE, 1.4) },
            Role::Level => line("level", (0xa9b7c6, 0x4a5866), 0.7),
            Role::Draft => line("draft", GREEN, 1.0),
            Role::Mark => Style { width: 1.2, stroke: Some(ORANGE), ..filled("mark", ORANGE, 0.55) },
            Role::Obstacle => Style { width: 1.0, stroke: Some(AMBER), ..filled("obstacle", AMBER, 0.75) },
            Role::Start => Style { width: 2.0, stroke: Some(GREEN), ..filled("start", GREEN, 0.25) },
            Role::End => Style { width: 2.0, stroke: Some(BLUE), ..filled("end", BLUE, 0.3) },
            Role::Goal => line("goal", (0xc1121f, 0xff6b6b), 2.2),
            Role::Seen => Style { width: 1.0, stroke: Some(GREEN), ..filled("seen", GREEN, 0.14) },
            Role::Wall => line("wall", (0x1b1f24, 0xe7eaee), 2.0),
            Role::Curve => line("curve", BLUE, 1.6),
            Role::SecondCurve => line("second-curve", ORANGE, 1.3),
            Role::Dot => filled("dot", GREEN, 0.55),
            Role::Box => Style { width: 1.0, stroke: Some(BLUE), ..filled("box", BLUE, 0.18) },
            Role::Mean => Style { width: 2.0, stroke: Some(ORANGE), ..filled("mean", ORANGE, 1.0) },
            Role::Limit => Style { dash: Some((5.0, 4.0)), ..line("limit", (0xc1121f, 0xff6b6b), 1.2) },
        }
    }
}

/// Which end of a text stands at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

/// A shape.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A map; the six numbers take its pixels to the picture as `x' = a x + c y + e`, `y' = b x + d y + f`.
    Image {
        /// The map.
        image: MapImage,
        /// `[a, b, c, d, e, f]`.
        matrix: [f64; 6],
    },
    /// Straight pieces from point to point.
    Chain {
        /// What it stands for.
        role: Role,
        /// Its corners.
        points: Vec<[f64; 2]>,
        /// The last corner is joined to the first.
        closed: bool,
    },
    /// A circle.
    Circle {
        /// What it stands for.
        role: Role,
        /// Its middle.
        center: [f64; 2],
        /// Its radius.
        radius: f64,
    },
    /// A line of letters.
    Text {
        /// What it stands for.
        role: Role,
        /// Its place on the base line.
        at: [f64; 2],
        /// Height of the letters.
        size: f64,
        /// Which end stands there.
        anchor: Anchor,
        /// Heavy letters.
        bold: bool,
        /// The letters.
        text: String,
    },
}

/// A picture before it is drawn.
#[derive(Debug, Clone, Default)]
pub struct Sketch {
    /// Pixels from left to right.
    pub width: f64,
    /// Pixels from top to bottom.
    pub height: f64,
    /// The shapes, those at the back first.
    pub shapes: Vec<Shape>,
}

impl Sketch {
    /// An empty sheet.
    pub fn sheet(width: f64, height: f64) -> Sketch {
        Sketch { width, height, shapes: Vec::new() }
    }

    /// A chain of straight pieces; fewer than two points draw nothing.
    pub fn chain(&mut self, role: Role, points: Vec<[f64; 2]>) {
        if points.len() > 1 {
            self.shapes.push(Shape::Chain { role, points, closed: false });
        }
    }

    /// A closed chain; fewer than three points draw nothing.
    pub fn ring(&mut self, role: Role, points: Vec<[f64; 2]>) {
        if points.len() > 2 {
            self.shapes.push(Shape::Chain { role, points, closed: true });
        }
    }

    /// A rectangle with its sides along the edges of the picture.
    pub fn rectangle(&mut self, role: Role, [left, top]: [f64; 2], [right, bottom]: [f64; 2]) {
        self.ring(role, vec![[left, top], [right, top], [right, bottom], [left, bottom]]);
    }

    /// A circle.
    pub fn circle(&mut self, role: Role, center: [f64; 2], radius: f64) {
        self.shapes.push(Shape::Circle { role, center, radius });
    }

    /// A line of letters.
    pub fn text(&mut self, role: Role, at: [f64; 2], size: f64, anchor: Anchor, text: impl Into<String>) {
        self.shapes.push(Shape::Text { role, at, size, anchor, bold: false, text: text.into() });
    }

    /// A heavy line of letters that starts at its place.
    pub fn heading(&mut self, at: [f64; 2], size: f64, text: impl Into<String>) {
        let (role, anchor) = (Role::Text, Anchor::Start);
        self.shapes.push(Shape::Text { role, at, size, anchor, bold: true, text: text.into() });
    }

    /// Puts the shapes of another sketch on top, moved by an offset.
    pub fn place(&mut self, other: Sketch, [dx, dy]: [f64; 2]) {
        let moved = |[x, y]: [f64; 2]| [x + dx, y + dy];
        self.shapes.extend(other.shapes.into_iter().map(|shape| match shape {
            Shape::Image { image, matrix: [a, b, c, d, e, f] } => {
                Shape::Image { image, matrix: [a, b, c, d, e + dx, f + dy] }
            }
            Shape::Chain { role, points, closed } => {
                Shape::Chain { role, points: points.into_iter().map(moved).collect(), closed }
            }
            Shape::Circle { role, center, radius } => Shape::Circle { role, center: moved(center), radius },
            Shape::Text { role, at, size, anchor, bold, text } => {
                Shape::Text { role, at: moved(at), size, anchor, bold, text }
            }
        }));
    }
}
