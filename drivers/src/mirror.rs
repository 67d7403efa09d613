//! Fast steering mirror: analog and serial command channels, strain gauge feedback.
