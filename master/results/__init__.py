"""What is kept of a march or a boundary, and how it is read, compared and exported."""
