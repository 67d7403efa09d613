//! Least total cost of pairing rows with columns (Kuhn, *Nav. Res. Logist. Q.* 2, 83, 1955; shortest augmenting paths
//! after Jonker & Volgenant, *Computing* 38, 325, 1987).

/// Column of each row of a square matrix of finite costs.
pub(super) fn assign(cost: &[Vec<f64>]) -> Vec<usize> {
    let n = cost.len();
    // Index 0 is nobody; rows and columns count from 1. `of_column` is the row that a column has.
    let mut row_price = vec![0.0; n + 1];
    let mut column_price = vec![0.0; n + 1];
    let mut of_column = vec![0; n + 1];
    for row in 1..=n {
        of_column[0] = row;
        let mut at = 0;
        let mut least = vec![f64::INFINITY; n + 1];
        let mut seen = vec![false; n + 1];
        let mut before = vec![0; n + 1];
        while of_column[at] != 0 {
            seen[at] = true;
            let owner = of_column[at];
            let mut delta = f64::INFINITY;
            let mut next = 0;
            for column in (1..=n).filter(|c| !seen[*c]) {
                let reduced = cost[owner - 1][column - 1] - row_price[owner] - column_price[column];
                if reduced < least[column] {
                    (least[column], before[column]) = (reduced, at);
                }
                if least[column] < delta {
                    (delta, next) = (least[column], column);
                }
            }
            for column in 0..=n {
                if seen[column] {
                    row_price[of_column[column]] += delta;
                    column_price[column] -= delta;
                } else {
                    least[column] -= delta;
                }
            }
            at = next;
        }
        while at != 0 {
            of_column[at] = of_column[before[at]];
            at = before[at];
        }
    }
    let mut columns = vec![0; n];
    for column in 1..=n {
        columns[of_column[column] - 1] = column - 1;
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_pairing_is_not_the_greedy_one() {
        let cost = vec![vec![1.0, 2.0, 9.0], vec![2.0, 9.0, 9.0], vec![9.0, 9.0, 3.0]];
        assert_eq!(assign(&cost), [1, 0, 2]);
        assert!(assign(&[]).is_empty());
    }
}
