mod bed;
mod engagement;
mod sight;
mod simple;
