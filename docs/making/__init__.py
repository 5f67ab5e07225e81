"""What makes the pages and the site that are not written by hand."""
