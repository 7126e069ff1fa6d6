use super::HeightMap;

/// The texels of `mask` in groups that hang together by their sides, across the border where the map
/// repeats.
pub(super) fn components(map: &HeightMap, mask: &[bool]) -> Vec<Vec<usize>> {
    let width = i64::from(map.size()[0]);
    let mut open = mask.to_vec();
    let mut all = Vec::new();
    for start in 0..mask.len() {
        if !std::mem::take(&mut open[start]) {
            continue;
        }
        let mut group = vec![start];
        let mut next = 0;
        while next < group.len() {
            let (x, y) = (group[next] as i64 % width, group[next] as i64 / width);
            for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
                let neighbour = map.index(x + dx, y + dy);
                if std::mem::take(&mut open[neighbour]) {
                    group.push(neighbour);
                }
            }
            next += 1;
        }
        all.push(group);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::Wrap;
    use super::super::test_photos::map;
    use super::*;

    #[test]
    fn groups_hang_together_by_sides_and_across_the_border() {
        #[rustfmt::skip]
        let mask = [
            1, 0, 0, 0, 1,
            1, 0, 1, 0, 0,
            0, 1, 0, 0, 1,
        ]
        .map(|m| m == 1);
        let sizes = |wrap| {
            let groups = components(&map([5, 3], wrap, |_, _| 0.0), &mask);
            groups.iter().map(Vec::len).collect::<Vec<_>>()
        };
        assert_eq!(sizes(Wrap::Clamp), [2, 1, 1, 1, 1]);
        assert_eq!(sizes(Wrap::Repeat), [4, 1, 1]);
    }
}
