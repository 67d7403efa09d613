//! DC link: rectifier, capacitor, shunt.
