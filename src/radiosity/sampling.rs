use glam::{Mat3, Vec3};
use sobol_burley::parts::owen_scramble_rev;

/// A well-mixed hash of two words (the finaliser of `MurmurHash3` over their combination).
pub(crate) fn hash(a: u32, b: u32) -> u32 {
    let mut h = a.wrapping_mul(0x9E37_79B9) ^ b.wrapping_mul(0x85EB_CA6B).rotate_left(15);
    h = h.wrapping_add(b);
    h ^= h >> 16;
    h = h.wrapping_mul(0x85EB_CA6B);
    h ^= h >> 13;
    h = h.wrapping_mul(0xC2B2_AE35);
    h ^ (h >> 16)
}

/// A number in 0..1 from a hash.
pub(crate) fn unit_float(hash: u32) -> f32 {
    (hash >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Four coordinates in 0..1 of point `index` of an Owen-scrambled Sobol sequence.
///
/// Sequences of different `seed` are independent; `set` picks four dimensions of one sequence.
/// A sequence has 65,536 points; what is beyond starts another.
pub(crate) fn sobol(index: u32, set: u32, seed: u32) -> [f32; 4] {
    let beyond = index >> 16;
    let seed = if beyond == 0 {
        seed
    } else {
        hash(seed, beyond)
    };
    sobol_burley::sample_4d(index & 0xFFFF, set, seed)
}

/// Two coordinates in 0..1 of point `index` of an Owen-scrambled Sobol sequence in two dimensions, several
/// times as fast as [`sobol`], and more even: its first `2^k` points have one in each of `2^k` boxes of any
/// shape.
///
/// With the digits of numbers reversed, the first coordinate is the index itself. Bit `k` of the second is the
/// sum of the index's bits `j` for which `C(j, k)` is odd, which says that `k` has no bit that `j` has not
/// (Lucas): sums over supersets, made in five steps (A. G. M. Ahmed, "An Implementation Algorithm of 2D Sobol
/// Sequence Fast, Elegant, and Compact", EGSR 2024).
pub(crate) fn sobol_2d(index: u32, seed: u32) -> [f32; 2] {
    let mut second = index;
    for (shift, mask) in [
        (1, 0x5555_5555),
        (2, 0x3333_3333),
        (4, 0x0F0F_0F0F),
        (8, 0x00FF_00FF),
        (16, 0x0000_FFFF),
    ] {
        second ^= (second >> shift) & mask;
    }
    let scrambled = |reversed, salt| owen_scramble_rev(reversed, hash(seed, salt)).reverse_bits();
    [scrambled(index, 0x5C1), scrambled(second, 0x5C2)].map(unit_float)
}

/// A direction about +Z with density cos θ / π, from the unit square (Shirley and Chiu's
/// concentric map of the square to the disc, lifted to the hemisphere: Malley's method).
pub(crate) fn cosine_hemisphere(u: f32, v: f32) -> Vec3 {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let quarter = std::f32::consts::FRAC_PI_4;
    let (r, phi) = if a.abs() > b.abs() {
        (a, quarter * (b / a))
    } else if b != 0.0 {
        (b, 2.0 * quarter - quarter * (a / b))
    } else {
        (0.0, 0.0)
    };
    let (sin, cos) = phi.sin_cos();
    Vec3::new(r * cos, r * sin, (1.0 - r * r).max(0.0).sqrt())
}

/// Direction `index` of a sequence about +Z with density cos θ / π.
pub(crate) fn cosine_direction(index: u32, seed: u32) -> Vec3 {
    let [u, v] = sobol_2d(index, seed);
    cosine_hemisphere(u, v)
}

/// Rotates +Z onto a unit normal (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
pub(crate) fn frame(n: Vec3) -> Mat3 {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    Mat3::from_cols(
        Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
        n,
    )
}

/// Barycentric weights of an area-uniform point of a triangle (Heitz 2019, "A Low-Distortion Map
/// Between Triangle and Square").
pub(crate) fn triangle(u: f32, v: f32) -> Vec3 {
    let (b0, b1) = if v > u {
        (0.5 * u, v - 0.5 * u)
    } else {
        (u - 0.5 * v, 0.5 * v)
    };
    Vec3::new(b0, b1, (1.0 - b0 - b1).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosine_directions_have_the_cosine_lobe_s_moments() {
        let n = 4096;
        let (mut mean, mut squares) = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..n {
            let [u, v, ..] = sobol(i, 0, 7);
            let d = cosine_hemisphere(u, v);
            assert!((d.length() - 1.0).abs() < 1e-5);
            mean += d / n as f32;
            squares += d * d / n as f32;
        }
        // ∫ ω cos/π = (0, 0, 2/3); ∫ ω² cos/π = (1/4, 1/4, 1/2).
        assert!(
            (mean - Vec3::new(0.0, 0.0, 2.0 / 3.0)).length() < 2e-3,
            "{mean}"
        );
        assert!(
            (squares - Vec3::new(0.25, 0.25, 0.5)).length() < 2e-3,
            "{squares}"
        );
    }

    /// The first `2^k` points have one in each of the boxes `2^i × 2^(k − i)`, whatever the scrambling.
    #[test]
    fn points_of_the_plane_are_a_sequence_of_nets() {
        for seed in [0, 1, 77] {
            for k in 0..9 {
                let points: Vec<[f32; 2]> = (0..1 << k).map(|i| sobol_2d(i, seed)).collect();
                for i in 0..=k {
                    let (columns, rows) = (1 << i, 1 << (k - i));
                    let mut met = vec![0; 1 << k];
                    for [u, v] in &points {
                        let [x, y] = [u * columns as f32, v * rows as f32].map(|c| c as usize);
                        met[y * columns + x] += 1;
                    }
                    assert!(met.iter().all(|&n| n == 1), "{k} {i}");
                }
            }
        }
    }

    #[test]
    fn frames_are_rotations_onto_the_normal() {
        for n in [
            Vec3::Z,
            -Vec3::Z,
            Vec3::X,
            Vec3::new(1.0, -2.0, -0.5).normalize(),
        ] {
            let m = frame(n);
            assert!((m * Vec3::Z - n).length() < 1e-6);
            assert!((m.determinant() - 1.0).abs() < 1e-5);
            assert!(
                (m.transpose() * m - Mat3::IDENTITY)
                    .to_cols_array()
                    .iter()
                    .all(|x| x.abs() < 1e-5)
            );
        }
    }

    #[test]
    fn triangle_points_are_uniform() {
        let n = 4096;
        let (mut mean, mut squares) = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..n {
            let [u, v, ..] = sobol(i, 0, 3);
            let b = triangle(u, v);
            assert!(b.min_element() >= 0.0 && (b.element_sum() - 1.0).abs() < 1e-6);
            mean += b / n as f32;
            squares += b * b / n as f32;
        }
        assert!((mean - Vec3::splat(1.0 / 3.0)).length() < 1e-3);
        assert!((squares - Vec3::splat(1.0 / 6.0)).length() < 1e-3);
    }
}
