#!/bin/sh
# Puts Mosquitto's configuration for Passo together: an authority of your own, the broker's certificate, the users of acl.
#
#     sudo sh docs/use/mosquitto/make-broker.sh shop.local /etc/mosquitto/passo
#
# HOST is the name or address by which agents call the broker. It prints each user's password once. Run again, it makes a new certificate
# and new passwords, and keeps the authority and your acl.
set -eu
umask 077
host=${1:?usage: make-broker.sh HOST FOLDER}
folder=${2:?usage: make-broker.sh HOST FOLDER}
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$folder"
cd "$folder"
[ -e acl ] || cp "$here/acl" acl
sed "s|/etc/mosquitto/passo|$folder|" "$here/mosquitto.conf" > passo.conf
[ -e ca.key ] || openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 3650 -subj "/CN=Passo shop" -keyout ca.key -out ca.crt 2> openssl.log
case $host in *[!0-9.]*) kind=DNS ;; *) kind=IP ;; esac
printf 'subjectAltName=%s:%s\n' "$kind" "$host" > names
{
    openssl req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj "/CN=$host" -keyout broker.key -out broker.csr
    openssl x509 -req -in broker.csr -CA ca.crt -CAkey ca.key -CAcreateserial -days 825 -extfile names -out broker.crt
} 2>> openssl.log
rm -f broker.csr names
: > passwords
for user in $(sed -n 's/^user //p' acl); do
    password=$(openssl rand -hex 16)
    echo "$user:$password" >> passwords
    echo "$user $password"
done
mosquitto_passwd -U passwords
chmod 644 ca.crt broker.crt
if [ "$(id -u)" = 0 ] && id mosquitto > /dev/null 2>&1; then
    chown -R mosquitto: "$folder"
    chown root: ca.key
fi
echo "agents want $folder/ca.crt; Mosquitto: include_dir, or ln -s $folder/passo.conf /etc/mosquitto/conf.d/" >&2
