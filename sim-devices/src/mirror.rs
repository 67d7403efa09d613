//! The fast steering mirror unit at the far end of its command channels.
