//! Disjoint sets of pixels.

/// Elements 0, 1, 2, ... in sets of which each has one of its members as its name.
pub(crate) struct UnionFind {
    parents: Vec<u32>,
    /// Members of the set, right for names only.
    sizes: Vec<u32>,
}

impl UnionFind {
    /// Every element in a set of its own.
    pub(crate) fn new(count: usize) -> UnionFind {
        UnionFind { parents: (0..count as u32).collect(), sizes: vec![1; count] }
    }

    /// The name of the element's set. Halves the path on the way, so that the next search is shorter.
    pub(crate) fn find(&mut self, mut element: u32) -> u32 {
        loop {
            let parent = self.parents[element as usize];
            let grandparent = self.parents[parent as usize];
            if parent == grandparent {
                return parent;
            }
            self.parents[element as usize] = grandparent;
            element = grandparent;
        }
    }

    /// Unites two sets; the larger one keeps its name.
    pub(crate) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        if a == b {
            return;
        }
        let (large, small) = if self.sizes[a as usize] >= self.sizes[b as usize] { (a, b) } else { (b, a) };
        self.parents[small as usize] = large;
        self.sizes[large as usize] += self.sizes[small as usize];
    }

    /// Members of the set of this name.
    pub(crate) fn size(&self, name: u32) -> u32 {
        self.sizes[name as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_scene::Stream;

    #[test]
    fn sets_are_those_of_relabelling_everything_at_each_union() {
        for seed in 0..50 {
            let mut random = Stream::new(seed);
            let mut sets = UnionFind::new(40);
            let mut labels: Vec<u32> = (0..40).collect();
            for _ in 0..30 {
                let (a, b) = (random.below(40) as u32, random.below(40) as u32);
                sets.unite(a, b);
                let (old, new) = (labels[a as usize], labels[b as usize]);
                labels.iter_mut().filter(|label| **label == old).for_each(|label| *label = new);
            }
            for a in 0..40 {
                let members = labels.iter().filter(|label| **label == labels[a as usize]).count() as u32;
                let name = sets.find(a);
                assert_eq!(sets.size(name), members, "seed {seed}");
                assert!(
                    (0..40).all(|b| (sets.find(b) == name) == (labels[b as usize] == labels[a as usize]))
                );
            }
        }
    }
}
