use super::{HeightMap, Warning, Wrap};

/// Neighbours across the border may differ by so many times what they do inside, root mean square.
const TOLD: f64 = 2.5;

/// Where a map that is to repeat has a step at its border.
pub(super) fn not_tiling(map: &HeightMap) -> Vec<Warning> {
    let size = map.size().map(i64::from);
    (0..2)
        .filter(|&axis| map.wrap()[axis] == Wrap::Repeat && size[axis] > 2)
        .filter_map(|axis| {
            let (length, lines) = (size[axis], size[1 - axis]);
            let height = |i: i64, line: i64| match axis {
                0 => f64::from(map.texel(i, line)),
                _ => f64::from(map.texel(line, i)),
            };
            let squares = |i: i64| -> f64 {
                let square = |line| (height(i + 1, line) - height(i, line)).powi(2);
                (0..lines).map(square).sum()
            };
            let inside = (0..length - 1).map(squares).sum::<f64>() / (length - 1) as f64;
            let times = (squares(length - 1) / inside).sqrt();
            // The same all over: 0 / 0.
            (times > TOLD).then_some(Warning::NotTiling { axis, times })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::test_photos::{map, noise};
    use super::*;
    use std::f32::consts::TAU;

    #[test]
    fn a_seam_is_told_and_a_tile_is_not() {
        let tile = |x: f32, y: f32| (TAU * (x + 2.0 * y) / 64.0).sin();
        assert_eq!(not_tiling(&map([64, 64], Wrap::Repeat, tile)), []);
        let rough = |x: f32, y: f32| noise(x as u32, y as u32, 1);
        assert_eq!(not_tiling(&map([64, 64], Wrap::Repeat, rough)), []);
        assert_eq!(not_tiling(&map([9, 9], Wrap::Repeat, |_, _| 0.3)), []);
        let ramp = |x: f32, y: f32| x + (TAU * y / 64.0).sin();
        let found = not_tiling(&map([64, 64], Wrap::Repeat, ramp));
        assert!(
            matches!(found[..], [Warning::NotTiling { axis: 0, times }] if times > 50.0),
            "{found:?}"
        );
        assert_eq!(not_tiling(&map([64, 64], Wrap::Clamp, ramp)), []);
    }
}
