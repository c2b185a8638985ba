//! How long a Markov chain takes to be absorbed.

/// Mean number of steps to absorption from state 0 of a Markov chain with the probabilities
/// `moves[i][j]` of a step from `i` to `j` and `exits[i]` of absorption; infinite beyond the range
/// of doubles.
///
/// The states are eliminated from the last to the first with a chance to stay that is not stored
/// but is what the other chances leave (Grassmann, Taksar and Heyman, *Operations Research* 33,
/// 1985): nothing is subtracted, so that every digit holds however rare the absorption is.
pub(super) fn absorption_time(mut moves: Vec<Vec<f64>>, mut exits: Vec<f64>) -> f64 {
    let mut steps = vec![1.0; exits.len()];
    while let (Some(row), Some(exit), Some(step)) = (moves.pop(), exits.pop(), steps.pop()) {
        let last = exits.len();
        let Some(others) = row.get(..last).filter(|others| !others.is_empty()) else {
            return step / exit;
        };
        let leaves = exit + others.iter().sum::<f64>();
        for ((row, to_exit), time) in moves.iter_mut().zip(&mut exits).zip(&mut steps) {
            let share = row.get(last).map_or(0.0, |chance| chance / leaves);
            for (chance, other) in row.iter_mut().zip(others) {
                *chance += share * other;
            }
            *to_exit += share * exit;
            *time += share * step;
        }
    }
    f64::NAN
}
