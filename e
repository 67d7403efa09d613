error: /tmp/gap/imp/ODRIVE-COGGING.mcap: File exists (os error 17); check that the folder exists, is writable and has free space, or choose another --out
