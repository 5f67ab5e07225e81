"""What tests share: references of their own (SciPy), made-up maps and configurations, random cells. No tests."""
