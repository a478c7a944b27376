//! Robust kernels: how much a constraint may pull that disagrees with all others.

/// What a constraint costs whose squared error, in units of its variance, is `s`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum RobustKernel {
    /// `s`: it pulls the harder, the farther it is off.
    #[default]
    Quadratic,
    /// Huber: `s` up to `c²`, then `2c sqrt(s) - c²`. For errors that are sometimes large.
    Huber {
        /// Errors of more deviations than this count less.
        c: f64,
    },
    /// Cauchy: `c² ln(1 + s/c²)`.
    Cauchy {
        /// As above.
        c: f64,
    },
    /// Geman-McClure: `c² s / (c² + s)`. Redescending: a constraint that is far off does not pull any more, as it would
    /// with switchable constraints (Agarwal et al., "Robust map optimization using dynamic covariance scaling", 2013).
    GemanMcClure {
        /// As above.
        c: f64,
    },
}

impl RobustKernel {
    /// Cost of a squared error.
    pub fn cost(self, s: f64) -> f64 {
        match self {
            RobustKernel::Quadratic => s,
            RobustKernel::Huber { c } if s <= c * c => s,
            RobustKernel::Huber { c } => 2.0 * c * s.sqrt() - c * c,
            RobustKernel::Cauchy { c } => c * c * (s / (c * c)).ln_1p(),
            RobustKernel::GemanMcClure { c } => c * c * s / (c * c + s),
        }
    }

    /// Slope of the cost: the weight that the constraint has left, 1 at most.
    pub fn weight(self, s: f64) -> f64 {
        match self {
            RobustKernel::Quadratic => 1.0,
            RobustKernel::Huber { c } if s <= c * c => 1.0,
            RobustKernel::Huber { c } => c / s.sqrt(),
            RobustKernel::Cauchy { c } => 1.0 / (1.0 + s / (c * c)),
            RobustKernel::GemanMcClure { c } => (c * c / (c * c + s)).powi(2),
        }
    }

    /// The kernel's own number makes sense.
    pub fn is_valid(self) -> bool {
        match self {
            RobustKernel::Quadratic => true,
            RobustKernel::Huber { c } | RobustKernel::Cauchy { c } | RobustKernel::GemanMcClure { c } => {
                c > 0.0 && c.is_finite()
            }
        }
    }
}
