//! Deterministic random numbers and smooth noise for scenes that are built in code.

/// SplitMix64, so that a scene is identical on all machines.
pub(crate) struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Numbers that follow from others.
    pub fn of(numbers: &[u64]) -> Self {
        Self(
            numbers.iter().fold(0x243F_6A88_85A3_08D3, |state, number| mix(state ^ mix(*number)).wrapping_add(*number)),
        )
    }

    /// The next number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        (mix(self.0) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next number between two bounds.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// The next whole number from 0 to `count - 1`.
    pub fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Whether something happens that has this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// The next direction; all are equally likely.
    pub fn direction(&mut self) -> glam::DVec3 {
        let (turn, up) = (self.between(0.0, std::f64::consts::TAU), self.between(-1.0, 1.0));
        let out = (1.0 - up * up).max(0.0).sqrt();
        glam::DVec3::new(out * turn.cos(), up, out * turn.sin())
    }
}

fn mix(z: u64) -> u64 {
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Value noise on the unit lattice, -1..1, once differentiable.
pub(crate) fn smooth([x, y, z]: [f64; 3]) -> f64 {
    let cell = [x.floor(), y.floor(), z.floor()];
    let fade = |t: f64| t * t * (3.0 - 2.0 * t);
    let f = [fade(x - cell[0]), fade(y - cell[1]), fade(z - cell[2])];
    let corner = |k: usize| {
        let at = |axis: usize| (cell[axis] as i64 + (k >> axis & 1) as i64) as u64;
        let hash = mix(at(0).wrapping_mul(0x8DA6_B343) ^ at(1).wrapping_mul(0xD816_3841_0000) ^ mix(at(2)));
        (hash >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..8)
        .map(|k| {
            let weight: f64 = (0..3).map(|axis| if k >> axis & 1 == 1 { f[axis] } else { 1.0 - f[axis] }).product();
            weight * corner(k)
        })
        .sum()
}

/// Several octaves of [`smooth`], each of twice the frequency and half the height.
pub(crate) fn fractal(p: [f64; 3], octaves: u32) -> f64 {
    (0..octaves).map(|k| f64::from(1 << k)).map(|frequency| smooth(p.map(|x| x * frequency)) / frequency).sum()
}
