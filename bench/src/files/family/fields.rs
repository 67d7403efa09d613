//! Keys of a family file.

use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, SCHEMA_FIELD, Shape};

/// Keys of a family file.
pub const FIELDS: &[Field] = &[
    SCHEMA_FIELD,
    Field::required("id", Shape::Text, "Name of the family; the ids of its units begin with it."),
    Field::required("title", Shape::Text, "Heading."),
    Field::default(
        "base",
        Shape::Text,
        "nominal",
        "Unit of the director whose settings are the nominal values: a shipped name, or a path beside this file.",
    ),
    Field::optional("setting", Shape::Tables(SETTING), "One table for settings that are spread alike."),
    Field::optional(
        "mode-factor",
        Shape::Tables(MODE_FACTOR),
        "One table for the frequencies of the structural modes and one for their damping ratios.",
    ),
    Field::optional(
        "correlation",
        Shape::Tables(CORRELATION),
        "One table for each pair of settings whose values go together. All others are independent.",
    ),
];

const KEYS: Field = Field::required(
    "keys",
    Shape::Texts,
    "Settings as `bench explain nominal` lists them, e.g. `mirror.coupling`; `*.inertia` means `az.inertia` and `el.inertia`. \
     Each is drawn on its own.",
);
const OF: Field = Field::required(
    "of",
    Shape::Choice(&["frequency", "damping"]),
    "What is multiplied, over all elevations alike, with a factor about 1 that is drawn for each mode.",
);
const DISTRIBUTION: Field = Field::default(
    "distribution",
    Shape::Choice(&["rectangular", "steps", "normal", "log-normal"]),
    "rectangular",
    "Shape of the distribution: rectangular about the nominal value; whole steps about it, all equally likely; normal with the \
     nominal value as its mean; log-normal with the nominal value as its median.",
);
const HALF_WIDTH: Field = Field::optional(
    "half-width",
    Shape::Text,
    "Half-width of a rectangular distribution: a share, `8 % of nominal`, or an absolute value, `2 N*m`.",
);
const STEP: Field = Field::optional("step", Shape::Text, "Size of a step, e.g. `50 us`.");
const STEPS: Field = Field::optional("steps", Shape::Integer, "Most steps to either side.");
const STANDARD_DEVIATION: Field = Field::optional(
    "standard-deviation",
    Shape::Text,
    "Standard deviation of a normal distribution: a share, `3 % of nominal`, or an absolute value, `2 N*m`.",
);
const GEOMETRIC_DEVIATION: Field = Field::optional(
    "geometric-deviation",
    Shape::Quantity(K::Ratio),
    "Geometric standard deviation of a log-normal distribution, above 1: with `1.2` two units of three lie between 1/1.2 and 1.2 \
     times the nominal value.",
);
const LIMITS: Field = Field::optional(
    "limits",
    Shape::Text,
    "Limits of a normal or log-normal distribution, e.g. `120 N*m .. 190 N*m`; values beyond them, or beyond the range of the \
     setting, are not drawn.",
);
const REASON: Field = Field::required("reason", Shape::Text, "Why units differ by so much.");

/// Keys of a `[[setting]]`.
const SETTING: &[Field] =
    &[KEYS, DISTRIBUTION, HALF_WIDTH, STEP, STEPS, STANDARD_DEVIATION, GEOMETRIC_DEVIATION, LIMITS, REASON];

/// Keys of a `[[mode-factor]]`.
const MODE_FACTOR: &[Field] =
    &[OF, DISTRIBUTION, HALF_WIDTH, STEP, STEPS, STANDARD_DEVIATION, GEOMETRIC_DEVIATION, LIMITS, REASON];

/// Keys of a `[[correlation]]`.
const CORRELATION: &[Field] = &[
    Field::required(
        "keys",
        Shape::Texts,
        "Two settings that this file draws, or frequencies or damping ratios of modes such as `az-structure.mode-1-frequency`; \
         `*` in both pairs azimuth with azimuth and elevation with elevation.",
    ),
    Field::required(
        "coefficient",
        Shape::Quantity(K::Ratio),
        "Correlation, above -1 and below 1, of the normal random numbers behind both; the rank correlation of the values is at \
         most 0.02 smaller.",
    ),
    REASON,
];
