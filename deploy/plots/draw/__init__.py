"""One module a kind of figure. Each drawing function takes all experiments' cells and returns
(figure, caption), or None where there is nothing to draw from."""
