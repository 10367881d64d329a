"""Parts of the SVG picture: the view, the symbols, the labels, the frame and the inset."""
