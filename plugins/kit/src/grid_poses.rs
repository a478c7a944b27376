//! Many poses as columns of `f32`, in a grid's own frame and in cells: what kernels over particles read.

/// Poses in cells: cell (0, 0) covers `[0, 1) x [0, 1)`.
///
/// Single precision is enough here: at 10,000 cells from the corner it resolves a thousandth of a cell.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GridPoses {
    /// Along the rows, cells.
    pub x: Vec<f32>,
    /// Along the columns, cells.
    pub y: Vec<f32>,
    /// Cosine of the heading.
    pub cos: Vec<f32>,
    /// Sine of the heading.
    pub sin: Vec<f32>,
}

impl GridPoses {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Takes all of them out.
    pub fn clear(&mut self) {
        [&mut self.x, &mut self.y, &mut self.cos, &mut self.sin].into_iter().for_each(Vec::clear);
    }

    /// Adds a pose at `x`, `y` (cells) with this heading.
    #[inline]
    pub fn push(&mut self, x: f64, y: f64, heading_rad: f64) {
        let (sin, cos) = heading_rad.sin_cos();
        self.x.push(x as f32);
        self.y.push(y as f32);
        self.cos.push(cos as f32);
        self.sin.push(sin as f32);
    }

    /// x, y, cosine and sine of each.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        let places = self.x.iter().zip(&self.y);
        let headings = self.cos.iter().zip(&self.sin);
        places.zip(headings).map(|((x, y), (cos, sin))| [*x, *y, *cos, *sin])
    }
}
