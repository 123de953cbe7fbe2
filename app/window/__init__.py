"""The window: menus, docking, dialogs and the session that joins panels to workers."""
