//! What numbers, kinds and texts are drawn from.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::built::parts::noise::Random;

/// A range of numbers: `[low, high]`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "[f64; 2]")]
pub(super) struct Span {
    low: f64,
    high: f64,
}

impl TryFrom<[f64; 2]> for Span {
    type Error = String;

    fn try_from([low, high]: [f64; 2]) -> Result<Self, String> {
        match low.is_finite() && high.is_finite() && low <= high {
            true => Ok(Self { low, high }),
            false => {
                Err(format!("[{low}, {high}] is no range: the first number must be finite and not above the second"))
            }
        }
    }
}

impl Span {
    /// Whether all of it lies in a range.
    pub fn is_within(&self, low: f64, high: f64) -> bool {
        low <= self.low && self.high <= high
    }

    /// A number; all are equally likely.
    pub fn even(&self, random: &mut Random) -> f64 {
        random.between(self.low, self.high)
    }

    /// A positive number; all factors are equally likely.
    pub fn log(&self, random: &mut Random) -> f64 {
        random.between(self.low.ln(), self.high.ln()).exp()
    }

    /// A whole number.
    pub fn count(&self, random: &mut Random) -> usize {
        self.even(&mut *random).round() as usize
    }
}

/// Kinds and how often each is drawn, relative to the others.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(transparent)]
pub(super) struct Weights<K: Ord>(BTreeMap<K, f64>);

impl<K: Ord + Copy + Default> Weights<K> {
    /// Why these are no weights.
    pub fn fault(&self) -> Option<String> {
        let sum: f64 = self.0.values().sum();
        let is_weight = |weight: &f64| (0.0..=1e9).contains(weight);
        match self.0.values().all(is_weight) && sum > 0.0 {
            true => None,
            false => Some("weights are numbers from 0, and one must be above 0".into()),
        }
    }

    /// How often a kind is drawn, relative to the others.
    pub fn of(&self, kind: K) -> f64 {
        self.0.get(&kind).copied().unwrap_or(0.0)
    }

    /// Without a kind; `None` if nothing would be left.
    pub fn without(&self, kind: K) -> Option<Self> {
        let rest =
            Self(self.0.iter().filter(|(known, _)| **known != kind).map(|(kind, weight)| (*kind, *weight)).collect());
        rest.fault().is_none().then_some(rest)
    }

    /// A kind.
    pub fn pick(&self, random: &mut Random) -> K {
        let mut rest = random.unit() * self.0.values().sum::<f64>();
        let mut last = None;
        for (kind, weight) in self.0.iter().filter(|(_, weight)| **weight > 0.0) {
            last = Some(*kind);
            rest -= weight;
            if rest < 0.0 {
                break;
            }
        }
        // There is one: weights are checked when a recipe is read.
        last.unwrap_or_default()
    }
}

/// Texts with numbers to draw: `{100..3200}`, or `{100..3200 log}` with all factors equally likely.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(transparent)]
pub(super) struct Texts(Vec<String>);

impl Texts {
    /// What is wrong with one of them.
    pub fn fault(&self) -> Option<String> {
        if self.0.is_empty() {
            return Some("a list of texts to choose from must have one".into());
        }
        self.0.iter().find_map(|text| filled(text, &mut Random::new(0)).err())
    }

    /// One of the texts, with its numbers, of four digits.
    pub fn pick(&self, random: &mut Random) -> String {
        let text = &self.0[random.index(self.0.len())];
        // Faults are found when a recipe is read.
        filled(text, random).unwrap_or_else(|_| text.clone())
    }
}

fn filled(text: &str, random: &mut Random) -> Result<String, String> {
    let wrong = || format!("'{text}': numbers to draw are written {{LOW..HIGH}} or {{LOW..HIGH log}}");
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('{') {
        let (inner, after) = after.split_once('}').ok_or_else(wrong)?;
        let (range, is_log) = inner.strip_suffix(" log").map_or((inner, false), |range| (range, true));
        let (low, high) = range.split_once("..").ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| wrong());
        let span = Span::try_from([number(low)?, number(high)?])?;
        if is_log && !span.is_within(f64::MIN_POSITIVE, f64::MAX) {
            return Err(format!("'{text}': a range with `log` has positive numbers"));
        }
        let value = if is_log { span.log(random) } else { span.even(random) };
        out += before;
        out += &rounded(value);
        rest = after;
    }
    Ok(out + rest)
}

/// A number with four digits.
fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    let scale = 10.0_f64.powi(digits.abs());
    let value = if digits >= 0 { (value * scale).round() / scale } else { (value / scale).round() * scale };
    value.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_have_their_numbers() {
        let texts = Texts(vec!["{-2..-1},{1..2}".into()]);
        assert_eq!(texts.fault(), None);
        let mut random = Random::new(3);
        for _ in 0..100 {
            let text = texts.pick(&mut random);
            let (low, high) = text.split_once(',').unwrap();
            assert!(low.len() <= 6 && high.len() <= 5, "{text}");
            assert!((-2.0..=-1.0).contains(&low.parse::<f64>().unwrap()), "{text}");
            assert!((1.0..=2.0).contains(&high.parse::<f64>().unwrap()), "{text}");
        }
        for wrong in ["{1}", "{1..", "{2..1}", "{a..b}", "{0..1 log}", "{1..inf}"] {
            assert!(Texts(vec![wrong.into()]).fault().is_some(), "{wrong}");
        }
        assert!(Texts(Vec::new()).fault().is_some());
        assert_eq!(rounded(1234.56), "1235");
        assert_eq!(rounded(123_456.0), "123500");
        assert_eq!(rounded(-0.012_345_6), "-0.01235");
    }

    /// A factor of ten below 1 is as likely as one above.
    #[test]
    fn factors_are_equally_likely() {
        let span = Span::try_from([0.1, 10.0]).unwrap();
        let mut random = Random::new(1);
        let small = (0..4000).filter(|_| span.log(&mut random) < 1.0).count();
        // Three standard deviations of a fair coin.
        assert!(small.abs_diff(2000) < 95, "{small}");
    }

    #[test]
    fn kinds_are_drawn_as_often_as_they_weigh() {
        let weights = Weights(BTreeMap::from([('a', 3.0), ('b', 0.0), ('c', 1.0)]));
        let mut random = Random::new(7);
        let drawn: Vec<char> = (0..4000).map(|_| weights.pick(&mut random)).collect();
        let count = |kind| drawn.iter().filter(|drawn| **drawn == kind).count();
        assert_eq!(count('b'), 0);
        assert!(count('c').abs_diff(1000) < 85, "{}", count('c'));
        assert!(Weights(BTreeMap::from([('a', 0.0)])).fault().is_some());
        assert!(Weights(BTreeMap::from([('a', -1.0), ('b', 2.0)])).fault().is_some());
        assert!(weights.without('a').is_some());
        assert!(Weights(BTreeMap::from([('a', 1.0)])).without('a').is_none());
    }
}
