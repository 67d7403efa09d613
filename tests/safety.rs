//! The safety chain on the whole loop: what goes wrong, and that the axes stand afterwards.

mod bed;
mod each_state;
mod endings;
mod ethercat;
mod external_laws;
mod hung;
mod limited;
mod mirror;
mod ordered;
mod states;
mod stop_by_terminal;
mod swing;
mod troubled;
