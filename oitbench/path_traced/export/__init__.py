"""A scene as Mitsuba sees it."""
