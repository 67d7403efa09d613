//! What is not an open loop is refused before anything is computed.

use super::{LEAST_LINES, Line, MarginError, Settings};

/// Numbers in their range, ascending, all lines exact or none.
pub(super) fn lines(lines: &[Line]) -> Result<(), MarginError> {
    if lines.len() < LEAST_LINES {
        return Err(MarginError::TooFewLines { found: lines.len() });
    }
    let mut before_hz = 0.0;
    for (k, line) in lines.iter().enumerate() {
        in_range(line).then_some(()).ok_or(MarginError::NotFinite { line: k })?;
        if line.frequency_hz <= before_hz {
            return Err(MarginError::NotAscending { line: k, before_hz, found_hz: line.frequency_hz });
        }
        if line.value.norm() <= 0.0 {
            return Err(MarginError::NoResponse { line: k });
        }
        before_hz = line.frequency_hz;
    }
    let exact = lines.iter().position(|l| l.variance <= 0.0);
    match exact {
        Some(line) if lines.iter().any(|l| l.variance > 0.0) => {
            Err(MarginError::MixedVariance { line, found: lines[line].variance })
        }
        _ => Ok(()),
    }
}

fn in_range(line: &Line) -> bool {
    let coherent = line.coherence.is_none_or(|c| (0.0..=1.0).contains(&c));
    let finite = line.frequency_hz.is_finite() && line.value.norm().is_finite() && line.variance.is_finite();
    finite && line.variance >= 0.0 && line.dof >= 0.0 && coherent
}

/// Settings in their range.
pub(super) fn settings(settings: &Settings) -> Result<(), MarginError> {
    let Settings { probability, least_coherence, .. } = *settings;
    let fine = probability > 0.0 && probability < 1.0 && (0.0..=1.0).contains(&least_coherence);
    fine.then_some(()).ok_or(MarginError::Settings { probability, least_coherence })
}
