//! Current loop of a drive.
