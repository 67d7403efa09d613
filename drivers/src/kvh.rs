//! KVH 1750/1775 inertial measurement unit: frames, checksum, configuration.
