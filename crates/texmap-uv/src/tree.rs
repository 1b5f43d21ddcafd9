//! A tree of boxes (bounding volume hierarchy) over points or triangles, and searches whose work has a bound.

use alloc::vec::Vec;
use texmap_math::glam::DVec3;

use crate::parallel;

/// Most items of a leaf.
const LEAF: usize = 8;

/// Items below this are sorted on one thread.
const SMALL: usize = 1 << 14;

/// A box around points, low and high corner.
pub(crate) type Bounds = [DVec3; 2];

/// Balanced by number. Items are halved along the widest axis of their middles, so that no input makes it deep.
pub(crate) struct BoxTree {
    /// In pre-order; both halves of a node have the same number of levels.
    nodes: Vec<Bounds>,
    items: Vec<u32>,
    /// Levels below the root.
    levels: u32,
}

impl BoxTree {
    /// A tree over items, whose boxes are finite. O(n log n).
    pub(crate) fn new(items: Vec<u32>, bounds: impl Fn(u32) -> Bounds + Sync) -> Self {
        let levels = items.len().div_ceil(LEAF).next_power_of_two().ilog2();
        let mut nodes = alloc::vec![[DVec3::ZERO; 2]; nodes_of(levels)];
        let place = |item| {
            let [low, high] = bounds(item);
            (low + high, item)
        };
        let mut places: Vec<Place> = items.into_iter().map(place).collect();
        if !places.is_empty() {
            fill(&mut nodes, &mut places, &bounds);
        }
        Self {
            nodes,
            items: places.into_iter().map(|(_, item)| item).collect(),
            levels,
        }
    }

    /// Visits the items of all leaves whose boxes, and those of all nodes above them, are `reached`. Others among them.
    /// False when the meter ran out, or `visit` said so, before the end.
    pub(crate) fn search(
        &self,
        meter: &mut Meter,
        reached: impl Fn(&Bounds) -> bool,
        mut visit: impl FnMut(u32, &mut Meter) -> bool,
    ) -> bool {
        // Node, first item, number of items, levels below. A node leaves at most one open half on every level.
        let mut open = [(0, 0, self.items.len(), self.levels); 34];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (node, start, items, levels) = open[count];
            if !meter.take(1) {
                return false;
            }
            if items == 0 || !reached(&self.nodes[node]) {
                continue;
            }
            if levels == 0 {
                if !meter.take(items as u64) {
                    return false;
                }
                let mut leaf = self.items[start..start + items].iter();
                if !leaf.all(|&item| visit(item, meter)) {
                    return false;
                }
                continue;
            }
            let (left, below) = (items / 2, levels - 1);
            open[count] = (
                node + nodes_of(levels).div_ceil(2),
                start + left,
                items - left,
                below,
            );
            open[count + 1] = (node + 1, start, left, below);
            count += 2;
        }
        true
    }
}

/// Nodes of a tree with this many levels below its root.
fn nodes_of(levels: u32) -> usize {
    (2 << levels) - 1
}

/// The sum of the corners of an item's box, twice its middle, and the item.
type Place = (DVec3, u32);

fn fill(nodes: &mut [Bounds], items: &mut [Place], bounds: &(impl Fn(u32) -> Bounds + Sync)) {
    let Some((root, below)) = nodes.split_first_mut() else {
        return;
    };
    let union = |a: Bounds, b: Bounds| [a[0].min(b[0]), a[1].max(b[1])];
    if below.is_empty() {
        let all = items.iter().map(|&(_, item)| bounds(item)).reduce(union);
        *root = all.unwrap_or_default();
        return;
    }
    let first = items[0].0;
    let (low, high) = items
        .iter()
        .fold((first, first), |(low, high), (middle, _)| {
            (low.min(*middle), high.max(*middle))
        });
    let size = high - low;
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let half = items.len() / 2;
    // Equal middles are settled by number: the halves are the same sets on every machine.
    items.select_nth_unstable_by(half, |(a, i), (b, j)| {
        a[axis].total_cmp(&b[axis]).then(i.cmp(j))
    });
    let parallel = items.len() > SMALL;
    let (left, right) = items.split_at_mut(half);
    let (left_nodes, right_nodes) = below.split_at_mut(below.len() / 2);
    if parallel {
        parallel::join(
            || fill(left_nodes, left, bounds),
            || fill(right_nodes, right, bounds),
        );
    } else {
        fill(left_nodes, left, bounds);
        fill(right_nodes, right, bounds);
    }
    *root = union(left_nodes[0], right_nodes[0]);
}

/// Steps that a search may still take.
pub(crate) struct Meter {
    left: u64,
}

impl Meter {
    /// Takes steps off; false once there are too few.
    pub(crate) fn take(&mut self, steps: u64) -> bool {
        let enough = steps <= self.left;
        self.left = self.left.saturating_sub(steps);
        enough
    }
}

/// Steps for searches around `count` items: 256 each, and up to 2^16 each while that makes no more than 2^28 together.
pub(crate) fn steps_for(count: usize) -> u64 {
    let count = count as u64;
    (count * 256).max((count << 16).min(1 << 28))
}

/// Finds something around each of `count` items within a number of steps, on all cores. Returns the finds, each with its
/// item, in the order of the items, and the items whose search did not come to its end. Steps are shared out evenly; what
/// items leave over goes to those that had too few, which begin again. The same result on any number of threads.
pub(crate) fn search_each<T: Send>(
    count: usize,
    steps: u64,
    search: impl Fn(usize, &mut Meter, &mut Vec<T>) -> bool + Sync + Send,
) -> (Vec<(u32, T)>, Vec<u32>) {
    let share_of = |left: u64, open: usize, share: u64| {
        (left / (open as u64).max(1)).min(share * 64 + (1 << 14))
    };
    let mut open: Vec<u32> = (0..count as u32).collect();
    let (mut found, mut left, mut share) = (Vec::new(), steps, share_of(steps, count, 0));
    loop {
        let parts = parallel::map_chunks(open.len(), |range| {
            let (mut own, mut found) = (Vec::new(), Vec::new());
            let (mut unfinished, mut used) = (Vec::new(), 0);
            for &item in &open[range] {
                let mut meter = Meter { left: share };
                let done = search(item as usize, &mut meter, &mut own);
                used += share - meter.left;
                if !done {
                    unfinished.push(item);
                }
                found.extend(own.drain(..).map(|thing| (item, thing, done)));
            }
            (found, unfinished, used)
        });
        let (mut unfinished, mut partial) = (Vec::new(), Vec::new());
        for (things, items, used) in parts {
            for (item, thing, done) in things {
                (if done { &mut found } else { &mut partial }).push((item, thing));
            }
            unfinished.extend(items);
            left -= used;
        }
        open = unfinished;
        let next = share_of(left, open.len(), share);
        if open.is_empty() || next < share * 2 {
            // Nobody begins again: parts of answers are better than none.
            found.extend(partial);
            found.sort_by_key(|(item, _)| *item);
            return (found, open);
        }
        share = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number in [0, 1) from a counter.
    fn random(k: u64) -> f64 {
        let x = (k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        ((x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64 / (1u64 << 53) as f64
    }

    #[test]
    fn a_search_meets_every_item_in_its_box_and_few_others() {
        for count in [0usize, 1, 7, 8, 9, 17, 1000, 40_000] {
            let point = |i: u32| {
                DVec3::from(core::array::from_fn(|k| {
                    random(3 * u64::from(i) + k as u64)
                }))
            };
            let tree = BoxTree::new((0..count as u32).collect(), |i| [point(i); 2]);
            let (low, high) = (DVec3::splat(0.4), DVec3::splat(0.5));
            let inside = |p: DVec3| (0..3).all(|k| low[k] <= p[k] && p[k] <= high[k]);
            let mut found = Vec::new();
            let mut meter = Meter { left: u64::MAX };
            let reached = |b: &Bounds| (0..3).all(|k| b[0][k] <= high[k] && low[k] <= b[1][k]);
            let done = tree.search(&mut meter, reached, |i, _| {
                found.push(i);
                true
            });
            assert!(done);
            let visited = found.len();
            found.retain(|&i| inside(point(i)));
            found.sort_unstable();
            let expected: Vec<u32> = (0..count as u32).filter(|&i| inside(point(i))).collect();
            assert_eq!(found, expected);
            assert!(visited <= expected.len() * 4 + 64, "{visited} of {count}");
        }
    }

    /// Steps are a bound: one item that needs all of them gets what the others leave, and a hundred cannot have it.
    #[test]
    fn steps_go_to_those_who_need_them() {
        let search = |needy: usize| {
            search_each(
                10_000,
                10_000 * 300,
                move |item, meter, out: &mut Vec<u32>| {
                    let need = if item < needy { 900_000 } else { 10 };
                    let mut took = 0;
                    while took < need && meter.take(1) {
                        took += 1;
                    }
                    out.push(took);
                    took == need
                },
            )
        };
        let (found, open) = search(1);
        assert!(open.is_empty() && found[0] == (0, 900_000) && found.len() == 10_000);
        assert!(found.iter().map(|(item, _)| *item).eq(0..10_000));
        let (found, open) = search(100);
        assert!(open.iter().copied().eq(0..100) && found.len() == 10_000);
        assert!(found.iter().map(|(item, _)| *item).eq(0..10_000));
        assert!(found[..100].iter().all(|(_, took)| *took > 1000));
    }
}
