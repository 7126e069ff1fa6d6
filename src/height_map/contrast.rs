use super::HeightMap;

/// How heights are brought to the range 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Stretch {
    /// Not at all.
    AsIs,
    /// The lowest becomes 0, the highest 1, exactly.
    #[default]
    Full,
    /// As many per cent of the heights as given are left out at either end before, and become 0 and 1
    /// themselves: a few wild texels then cost no contrast. Limits: above 0, below 50.
    Percentile(f32),
}

/// Lowest and highest height that count.
fn ends(heights: &[f32], stretch: Stretch) -> [f32; 2] {
    let all = |heights: &[f32]| {
        heights
            .iter()
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &h| {
                [low.min(h), high.max(h)]
            })
    };
    let Stretch::Percentile(percent) = stretch else {
        return all(heights);
    };
    let out = (f64::from(percent) / 100.0 * heights.len() as f64).round() as usize;
    // Below 50 %, so that one is left at least.
    let out = out.min((heights.len() - 1) / 2);
    let mut sorted = heights.to_vec();
    let mut at = |i: usize| *sorted.select_nth_unstable_by(i, f32::total_cmp).1;
    [at(out), at(heights.len() - 1 - out)]
}

/// Heights from 0 to 1, or `None` if all that count are equal: they are ½ then.
///
/// In f64, where `(h − low) / (high − low)` is exactly 0 and 1 at its ends and the difference of two
/// `f32` cannot overflow.
pub(super) fn stretch(map: &HeightMap, stretch: Stretch) -> Option<HeightMap> {
    if stretch == Stretch::AsIs {
        return Some(map.clone());
    }
    let [low, high] = ends(map.heights(), stretch).map(f64::from);
    let range = high - low;
    let stretched = map.heights().iter().map(|&h| {
        let share = (f64::from(h).clamp(low, high) - low) / range;
        share as f32
    });
    (range > 0.0).then(|| map.with_heights(stretched.collect()))
}

/// High becomes low, in the same range.
pub(super) fn invert(map: &HeightMap) -> HeightMap {
    let [low, high] = ends(map.heights(), Stretch::Full).map(f64::from);
    let turned = |&h: &f32| (low + high - f64::from(h)).clamp(low, high) as f32;
    map.with_heights(map.heights().iter().map(turned).collect())
}

#[cfg(test)]
mod tests {
    use super::super::Wrap;
    use super::super::test_photos::noise;
    use super::*;

    fn row(heights: Vec<f32>) -> HeightMap {
        HeightMap::new([heights.len() as u32, 1], heights, [Wrap::Clamp; 2]).unwrap()
    }

    /// Bump test 17: to the bit at both ends, whatever the range.
    #[test]
    fn ends_are_exactly_0_and_1() {
        for scale in [1e-44, 1e-20, 0.3, 77.7, 3e38] {
            let heights: Vec<f32> = (0..1000)
                .map(|x| (2.0 * noise(x, 0, 7) - 1.0) * scale)
                .collect();
            let found = stretch(&row(heights), Stretch::Full).unwrap();
            let found = ends(found.heights(), Stretch::Full);
            assert_eq!(found, [0.0, 1.0], "{scale}");
        }
    }

    /// Bump test 17: 0.1 % of salt and pepper.
    #[test]
    fn percentiles_pass_over_wild_texels() {
        let clean: Vec<f32> = (0..10_000).map(|i| 0.4 + 0.2 * i as f32 / 9999.0).collect();
        let mut salted = clean.clone();
        for i in 0..10 {
            salted[i * 997 + 13] = if i % 2 == 0 { 1.0 } else { 0.0 };
        }
        let worst = |how| {
            let clean = stretch(&row(clean.clone()), Stretch::Full).unwrap();
            let found = stretch(&row(salted.clone()), how).unwrap();
            let off = |(i, (a, b)): (usize, (&f32, &f32))| {
                let wild = salted[i] == 1.0 || salted[i] == 0.0;
                if wild { 0.0 } else { (a - b).abs() }
            };
            let pairs = clean.heights().iter().zip(found.heights());
            pairs.enumerate().map(off).fold(0.0, f32::max)
        };
        let robust = worst(Stretch::Percentile(0.5));
        assert!(robust < 0.006, "{robust}");
        assert!(worst(Stretch::Full) > 0.3);
        let found = stretch(&row(salted.clone()), Stretch::Percentile(0.5)).unwrap();
        assert_eq!(ends(found.heights(), Stretch::Full), [0.0, 1.0]);
    }

    /// Bump test 17: nothing to stretch.
    #[test]
    fn equal_heights_have_no_contrast() {
        for (heights, how) in [
            (vec![0.3; 9], Stretch::Full),
            (vec![0.3], Stretch::Full),
            (vec![0.3], Stretch::Percentile(10.0)),
            // All but one are equal.
            (
                [vec![0.3; 99], vec![0.9]].concat(),
                Stretch::Percentile(2.0),
            ),
        ] {
            assert_eq!(stretch(&row(heights), how), None);
        }
    }

    #[test]
    fn high_becomes_low() {
        let found = invert(&row(vec![2.0, 3.0, 7.0]));
        assert_eq!(found.heights(), [7.0, 6.0, 2.0]);
    }
}
