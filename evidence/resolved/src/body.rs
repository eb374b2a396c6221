//! The rigid body: a sphere, or a cylinder that flies along its axis with its flat face ahead. It does not
//! turn.

#[derive(Clone, Copy, Default, PartialEq)]
pub enum Shape {
    #[default]
    Sphere,
    /// Cylinder of this length; its place is that of the face.
    Cylinder(f64),
}

#[derive(Clone, Default)]
pub struct Body {
    pub shape: Shape,
    pub radius: f64,
    pub mass: f64,
    pub friction: f64,
    pub at: [f64; 3],
    pub v: [f64; 3],
    pub old: [f64; 3],
    pub lost: [f64; 3],
    pub taken: f64,
}

impl Body {
    pub fn drift(&mut self, dt: f64) {
        self.taken -= 0.5 * self.mass * self.half();
        for a in 0..3 {
            self.at[a] += dt * self.v[a];
        }
        (self.old, self.lost) = (self.v, [0.0; 3]);
    }

    fn half(&self) -> f64 {
        (0..3).map(|a| self.lost[a] * (self.old[a] + self.v[a])).sum()
    }

    /// Kinetic energy at t_n with what dissipation took.
    pub fn energy(&self) -> f64 {
        let square = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>();
        0.25 * self.mass * (square(self.v) + square(self.old)) + self.taken - 0.25 * self.mass * self.half()
    }

    /// Depth of a point, given relative to the body's place, below the surface at the distance `off` from the
    /// body, and the normal there.
    pub fn depth(&self, p: [f64; 3], off: f64) -> Option<(f64, [f64; 3])> {
        match self.shape {
            Shape::Sphere => {
                let (square, reach) = (p.iter().map(|x| x * x).sum::<f64>(), self.radius + off);
                (square < reach * reach && square > 0.0).then(|| {
                    let r = square.sqrt();
                    (reach - r, p.map(|x| x / r))
                })
            }
            Shape::Cylinder(length) => {
                let r = (p[0] * p[0] + p[1] * p[1]).sqrt();
                let (across, ahead) = (r - self.radius, p[2]);
                if across >= off || ahead >= off || ahead < -length {
                    return None;
                }
                let out = if r > 0.0 { [p[0] / r, p[1] / r] } else { [0.0; 2] };
                let (distance, side, front) = if across > 0.0 && ahead > 0.0 {
                    let distance = (across * across + ahead * ahead).sqrt();
                    (distance, across / distance, ahead / distance)
                } else if ahead > across {
                    (ahead, 0.0, 1.0)
                } else {
                    (across, 1.0, 0.0)
                };
                (distance < off).then(|| (off - distance, [side * out[0], side * out[1], front]))
            }
        }
    }

    /// Whether a point relative to the body's place may touch before it has moved so far.
    pub fn near(&self, p: [f64; 3], margin: f64) -> bool {
        let (reach, back) = match self.shape {
            Shape::Sphere => (self.radius, self.radius),
            Shape::Cylinder(length) => (0.0, length),
        };
        p[0].abs() < self.radius + margin
            && p[1].abs() < self.radius + margin
            && p[2] < reach + margin
            && p[2] > -back - margin
    }
}
