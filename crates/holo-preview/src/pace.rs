//! How large the images of a moving camera are, so that enough of them come in a second.

use std::time::Duration;

/// An image takes no longer than this, so that more than 15 come in a second.
const BUDGET: Duration = Duration::from_millis(60);

/// The sides of an image are two to eight eighths of those that the page wants. A size without steps would change with every
/// image, and the view would flicker.
const WHOLE: usize = 8;
const LEAST: usize = 2;

/// The size of the next image of a moving camera. It follows from the time that the last images took.
#[derive(Debug)]
pub(crate) struct Pace {
    eighths: usize,
}

impl Default for Pace {
    fn default() -> Self {
        Self { eighths: WHOLE }
    }
}

impl Pace {
    /// The size of the next image, (width, height).
    pub fn size(&self, wanted: [usize; 2]) -> [usize; 2] {
        wanted.map(|side| (side * self.eighths / WHOLE).max(1))
    }

    /// An image of that size has been drawn. If it took too long, the next one is as small as it must be; if there is room for
    /// a step, the next one is a step larger.
    pub fn drawn(&mut self, took: Duration) {
        let now = self.eighths as f64;
        let fits = now * (BUDGET.as_secs_f64() / took.as_secs_f64().max(1e-9)).sqrt();
        self.eighths = if fits >= now + 1.0 { self.eighths + 1 } else { now.min(fits.round()) as usize };
        self.eighths = self.eighths.clamp(LEAST, WHOLE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The widths of images where each takes so long, and so long a pixel more.
    fn widths(pace: &mut Pace, ms: f64, ns_per_pixel: f64) -> Vec<usize> {
        let draw = |_| {
            let [width, height] = pace.size([480, 320]);
            pace.drawn(Duration::from_secs_f64(ms * 1e-3 + (width * height) as f64 * ns_per_pixel * 1e-9));
            width
        };
        (0..20).map(draw).collect()
    }

    #[test]
    fn images_are_as_large_as_their_time_allows() {
        let mut pace = Pace::default();
        // The first one is whole; then 60,000 pixels take 58 of the 60 ms, and 86,400 would take 79 ms.
        let slow = widths(&mut pace, 10.0, 800.0);
        assert_eq!((slow[0], slow[19]), (480, 300), "{slow:?}");
        let fast = widths(&mut pace, 5.0, 100.0);
        assert_eq!((fast[0], fast[19]), (300, 480), "{fast:?}");
        assert!(fast.windows(2).all(|pair| (pair[0]..=pair[0] + 60).contains(&pair[1])), "{fast:?}");
        // However slow it is, something is seen.
        assert_eq!(widths(&mut pace, 1e4, 0.0)[19], 120);
    }
}
