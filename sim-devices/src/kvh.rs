//! The KVH inertial measurement unit at the far end of its line.
