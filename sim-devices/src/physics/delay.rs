//! Transport delay: what was pushed each step comes out a whole number of steps later.

/// A line of values, one per step.
#[derive(Clone, Debug)]
pub struct DelayLine<T> {
    ring: Vec<T>,
    next: usize,
    through: bool,
}

impl<T: Copy> DelayLine<T> {
    /// A line that delays by `steps_count` steps, all of them `fill` so far; it remembers at least one.
    pub fn new(steps_count: usize, fill: T) -> Self {
        Self { ring: vec![fill; steps_count.max(1)], next: 0, through: steps_count == 0 }
    }

    /// One step on; what was pushed as many steps ago as the line remembers.
    #[inline]
    pub fn push(&mut self, value: T) -> T {
        let oldest = std::mem::replace(&mut self.ring[self.next], value);
        self.next += 1;
        if self.next == self.ring.len() {
            self.next = 0;
        }
        if self.through { value } else { oldest }
    }

    /// What was pushed `steps_ago` pushes before the newest (0 is the newest); the oldest if the line is shorter.
    #[inline]
    pub fn ago(&self, steps_ago: usize) -> T {
        let length = self.ring.len();
        let back = steps_ago.min(length - 1) + 1;
        self.ring[if self.next >= back { self.next - back } else { self.next + length - back }]
    }
}

/// Steps of a delay.
pub fn steps(delay_s: f64, step_s: f64) -> usize {
    (delay_s / step_s).round().max(0.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_in_comes_out_so_many_steps_later() {
        let mut line = DelayLine::new(3, 0);
        let out: Vec<i32> = (1..=6).map(|k| line.push(k)).collect();
        assert_eq!(out, [0, 0, 0, 1, 2, 3]);
        assert_eq!(DelayLine::new(0, 0).push(7), 7);
        assert_eq!([line.ago(0), line.ago(1), line.ago(2), line.ago(9)], [6, 5, 4, 4]);
    }
}
