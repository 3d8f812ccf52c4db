"""The daemon: one task a device, bounded lanes to recorder and publisher."""
