#!/bin/sh
# Installs Mesa's software Vulkan driver (lavapipe) where no Vulkan driver is found and where it can: as root, with
# passwordless sudo, or not at all. Always succeeds; the program falls back to its CPU path and says so.
set -u
for folder in /usr/share/vulkan/icd.d /etc/vulkan/icd.d /usr/local/share/vulkan/icd.d; do
  if ls "$folder"/*.json >/dev/null 2>&1 && ldconfig -p 2>/dev/null | grep -q libvulkan.so.1; then exit 0; fi
done
[ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] && exit 0
if ! command -v apt-get >/dev/null 2>&1; then
  echo "no Vulkan driver and no apt-get: install Mesa's lavapipe by hand, or the CPU path is taken" >&2; exit 0
fi
if [ "$(id -u)" = 0 ]; then as_root=""; elif sudo -n true >/dev/null 2>&1; then as_root="sudo -n"; else
  echo "no Vulkan driver, and neither root nor sudo to install one: the CPU path is taken" >&2; exit 0
fi
echo "installing Mesa's software Vulkan driver (mesa-vulkan-drivers, libvulkan1)" >&2
export DEBIAN_FRONTEND=noninteractive
# shellcheck disable=SC2086
{ $as_root apt-get update -qq && $as_root apt-get install -y -qq --no-install-recommends mesa-vulkan-drivers libvulkan1; } >/dev/null 2>&1 \
  || echo "the Vulkan driver could not be installed: the CPU path is taken" >&2
exit 0
