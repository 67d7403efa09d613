//! Turbulence: tip-tilt of the line of sight.
